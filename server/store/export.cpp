#include "server/store/export.h"

#include <string>

#include "common/draco_codec.h"
#include "common/error.h"
#include "common/mesh_file.h"
#include "common/mesh_joiner.h"
#include "server/store/texture_export.h"

namespace lode::store {

Mesh readRung(const Reader& reader, const Node& node, uint32_t rung_number) {
  const Rung& rung = node.rungs[rung_number];
  Mesh mesh;
  mesh.attributes = reader.summary().attributes;
  if (!rung.payload) return mesh;
  const std::vector<std::byte> bytes = reader.readBlob(rung.payload.number);
  const PayloadExpectation expected{.triangles = rung.triangles,
                                    .vertices = rung.vertices,
                                    .attributes = reader.summary().attributes,
                                    .box = node.box};
  try {
    return decodePayload(bytes, reader.summary().lattice.step, expected);
  } catch (const Error& error) {
    throw Error(error.code(), reader.path().string() + ": node " + describeKey(node.key) + ", rung " +
                                  std::to_string(rung_number) + ": " + error.what());
  }
}

Mesh assembleCut(const Reader& reader, const Cut& cut) {
  MeshJoiner joiner(reader.summary().attributes, cut.triangles);
  for (const CutItem item : cut.items) joiner.add(readRung(reader, reader.nodes()[item.node], item.rung));
  return joiner.finish();
}

void exportCut(const Reader& reader, const Cut& cut, const std::filesystem::path& path) {
  const Mesh mesh = assembleCut(reader, cut);
  writeMesh(path, mesh, reader.summary().lattice, exportTextures(reader, path));
}

}  // namespace lode::store
