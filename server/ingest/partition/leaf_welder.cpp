#include "server/ingest/partition/leaf_welder.h"

#include <utility>

#include "server/ingest/mesh/mesh_edges.h"
#include "server/ingest/partition/leaf_mesh.h"

namespace lode::ingest {

namespace {

void keepTrianglesAt(std::span<const uint32_t> positions, NodeMesh& mesh) {
  std::vector<bool> is_wanted(mesh.positions.size());
  for (const uint32_t position : positions) is_wanted[position] = true;
  const auto is_at = [&](uint32_t wedge) -> bool { return is_wanted[mesh.wedge_position[wedge]]; };
  std::erase_if(mesh.triangles,
                [&](const glm::u32vec3& t) { return !is_at(t.x) && !is_at(t.y) && !is_at(t.z); });
}

}  // namespace

LeafWelder::LeafWelder(BorderTable& table, AttributeSet attributes, const CreaseAngle& crease,
                       Helpers& helpers, Sink sink)
    : attributes_(attributes),
      crease_(crease),
      welded_(helpers, [&table, sink = std::move(sink)](Welded&& welded) {
        sink(welded.mesh.bytes(), welded.digest);
        for (size_t i = 0; i < welded.border.size(); ++i) {
          for (ListedFan& fan : welded.fans[i]) {
            fan.leaf = welded.leaf;
            table.add(welded.border[i], fan);
          }
        }
      }) {}

void LeafWelder::add(uint32_t leaf, std::span<const std::byte> records) {
  welded_.push([this, leaf, copy = std::vector(records.begin(), records.end())] { return weld(leaf, copy); });
}

NodeMesh LeafWelder::weld(std::span<const std::byte> records) {
  MeshWelder welder;
  {
    std::lock_guard lock(mutex_);
    if (!welders_.empty()) {
      welder = std::move(welders_.back());
      welders_.pop_back();
    }
  }
  NodeMesh mesh = weldSoup(records, attributes_, welder);
  std::lock_guard lock(mutex_);
  welders_.push_back(std::move(welder));
  return mesh;
}

LeafWelder::Welded LeafWelder::weld(uint32_t leaf, std::span<const std::byte> records) {
  NodeMesh mesh = weld(records);
  Welded welded;
  welded.leaf = leaf;
  putLeaf(welded.mesh, mesh);
  welded.digest = digestOf(welded.mesh.bytes());
  const std::vector<uint32_t> border = findBorder(mesh);
  for (const uint32_t position : border) welded.border.push_back(mesh.positions[position]);
  if (attributes_.has(AttributeSet::kNormal)) {
    welded.fans.assign(border.size(), {ListedFan{}});
  } else {
    keepTrianglesAt(border, mesh);
    welded.fans = listFans(mesh, findFans(mesh, crease_), border);
  }
  return welded;
}

}  // namespace lode::ingest
