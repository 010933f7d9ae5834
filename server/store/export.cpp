#include "server/store/export.h"

#include <string>

#include "common/codec/draco_codec.h"
#include "common/error.h"
#include "common/io/mesh_file.h"
#include "common/io/mesh_joiner.h"
#include "server/store/texture_export.h"

namespace lode::store {

Mesh readLod(const Reader& reader, const Node& node, uint32_t lod_number) {
  const Lod& lod = node.lods[lod_number];
  Mesh mesh;
  mesh.attributes = reader.summary().attributes;
  if (!lod.payload) return mesh;
  const std::vector<std::byte> bytes = reader.readBlob(lod.payload.number);
  const PayloadExpectation expected{.triangles = lod.triangles,
                                    .vertices = lod.vertices,
                                    .attributes = reader.summary().attributes,
                                    .box = node.box};
  try {
    return decodePayload(bytes, reader.summary().lattice.step, expected);
  } catch (const Error& error) {
    throw Error(error.code(), reader.path().string() + ": node " + describeKey(node.key) + ", LOD " +
                                  std::to_string(lod_number) + ": " + error.what());
  }
}

Mesh assembleCut(const Reader& reader, const Cut& cut) {
  MeshJoiner joiner(reader.summary().attributes, cut.triangles);
  for (const CutItem item : cut.items) joiner.add(readLod(reader, reader.nodes()[item.node], item.lod));
  return joiner.finish();
}

void exportCut(const Reader& reader, const Cut& cut, const std::filesystem::path& path) {
  const Mesh mesh = assembleCut(reader, cut);
  writeMesh(path, mesh, reader.summary().lattice, exportTextures(reader, path));
}

}  // namespace lode::store
