#include "server/ingest/partition/leaf_mesh.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "common/codec/surface_normals.h"
#include "common/error.h"

namespace lode::ingest {

NodeMesh weldSoup(std::span<const std::byte> records, AttributeSet attributes, MeshWelder& welder) {
  const size_t record_bytes = soupBytes(attributes);
  const size_t triangles = records.size() / record_bytes;
  welder.begin(attributes, triangles, triangles);
  for (size_t t = 0; t < triangles; ++t) {
    const SoupTriangle triangle = loadSoup(records.subspan(t * record_bytes, record_bytes));
    glm::u32vec3 wedges;
    for (int k = 0; k < 3; ++k) {
      wedges[k] = welder.addCorner(triangle.corners[k], kNeverLocked, triangle.attributes[k]);
    }
    welder.addTriangle(wedges);
  }
  return welder.finish();
}

// Omits the wedges of a mesh without attributes, because each position has one wedge.
void putLeaf(RecordWriter& record, const NodeMesh& mesh) {
  record.putAll(mesh.positions);
  record.putAll(mesh.triangles);
  if (mesh.attributes.bits == 0) return;
  record.putAll(mesh.wedge_position);
  record.putAll(mesh.wedge_attributes);
}

NodeMesh getLeaf(RecordReader& record, AttributeSet attributes) {
  NodeMesh mesh;
  mesh.attributes = attributes;
  mesh.positions = record.getAll<PositionCode>();
  mesh.triangles = record.getAll<glm::u32vec3>();
  if (attributes.bits != 0) {
    mesh.wedge_position = record.getAll<uint32_t>();
    mesh.wedge_attributes = record.getAll<VertexAttributes>();
  } else {
    mesh.wedge_position.resize(mesh.positions.size());
    std::iota(mesh.wedge_position.begin(), mesh.wedge_position.end(), 0u);
  }
  mesh.lca_depth.assign(mesh.positions.size(), kNeverLocked);
  const size_t wedges = mesh.wedge_position.size();
  const auto isTriangle = [&](glm::u32vec3 t) {
    if (t.x >= wedges || t.y >= wedges || t.z >= wedges) return false;
    const uint32_t a = mesh.wedge_position[t.x], b = mesh.wedge_position[t.y], c = mesh.wedge_position[t.z];
    return a != b && b != c && c != a;
  };
  const bool is_sound =
      record.atEnd() && (attributes.bits == 0 || mesh.wedge_attributes.size() == wedges) &&
      std::ranges::all_of(mesh.wedge_position, [&](uint32_t at) { return at < mesh.positions.size(); }) &&
      std::ranges::all_of(mesh.triangles, isTriangle);
  if (!is_sound)
    throw Error(ErrorCode::kFormat,
                "the build's temporary file of leaves is damaged; build without --resume");
  return mesh;
}

std::vector<glm::i64vec3> sumNormals(const NodeMesh& mesh) {
  std::vector<glm::i64vec3> sums(mesh.positions.size(), glm::i64vec3(0));
  for (const glm::u32vec3& t : mesh.triangles) {
    const uint32_t corners[3] = {mesh.wedge_position[t.x], mesh.wedge_position[t.y],
                                 mesh.wedge_position[t.z]};
    const glm::i64vec3 normal =
        areaNormal(mesh.positions[corners[0]], mesh.positions[corners[1]], mesh.positions[corners[2]]);
    for (const uint32_t corner : corners) sums[corner] += normal;
  }
  return sums;
}

}  // namespace lode::ingest
