#include "server/ingest/partition/leaf_welder.h"

#include <utility>

#include "server/ingest/partition/leaf_mesh.h"

namespace lode::ingest {

LeafWelder::LeafWelder(BorderTable& table, AttributeSet attributes, unsigned threads, Sink sink)
    : attributes_(attributes),
      welders_(threads),
      welded_(threads - 1, [&table, sink = std::move(sink)](Welded&& welded) {
        sink(welded.mesh.bytes());
        for (size_t i = 0; i < welded.border.size(); ++i)
          table.add(welded.border[i], welded.leaf, welded.normals[i]);
      }) {}

void LeafWelder::add(uint32_t leaf, std::span<const std::byte> records) {
  MeshWelder& welder = welders_[next_welder_++ % welders_.size()];
  welded_.push([this, leaf, &welder, copy = std::vector(records.begin(), records.end())] {
    return weld(leaf, copy, welder);
  });
}

LeafWelder::Welded LeafWelder::weld(uint32_t leaf, std::span<const std::byte> records,
                                    MeshWelder& welder) const {
  const bool has_normals = attributes_.has(AttributeSet::kNormal);
  const NodeMesh mesh = weldSoup(records, attributes_, welder);
  const std::vector<glm::i64vec3> normals = has_normals ? std::vector<glm::i64vec3>() : sumNormals(mesh);
  Welded welded;
  welded.leaf = leaf;
  putLeaf(welded.mesh, mesh);
  for (const uint32_t position : findBorder(mesh)) {
    welded.border.push_back(mesh.positions[position]);
    welded.normals.push_back(has_normals ? glm::i64vec3(0) : normals[position]);
  }
  return welded;
}

}  // namespace lode::ingest
