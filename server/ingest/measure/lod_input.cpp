#include "server/ingest/measure/lod_input.h"

#include <algorithm>
#include <utility>

#include "server/ingest/mesh/mesh_edges.h"

namespace lode::ingest {

glm::u32vec2 imageOf(glm::u32vec2 ends, std::span<const uint32_t> remap) noexcept {
  const auto imageOfEnd = [&](uint32_t end) { return end == kVanished ? kVanished : remap[end]; };
  return {imageOfEnd(ends.x), imageOfEnd(ends.y)};
}

ReferenceBoundaries referencesIn(const LodInput& input, std::span<const uint32_t> remap,
                                 float boundary_gap_steps, size_t most) {
  ReferenceBoundaries references{{}, input.referenceGapSteps()};
  for (uint32_t i = 0; i < input.referenceCount(); ++i) {
    ReferenceBoundary reference = input.reference(i);
    reference.near = imageOf(reference.near, remap);
    if (reference.near == glm::u32vec2(kVanished)) continue;
    if (references.boundaries.size() == most) return {{}, boundary_gap_steps};
    references.boundaries.push_back(reference);
  }
  return references;
}

LodInput::LodInput(NodeMesh mesh, int depth, std::optional<float> off_steps, ReferenceBoundaries references)
    : mesh_(std::move(mesh)),
      walk_(mesh_),
      off_steps_(off_steps),
      references_(std::move(references)),
      boundaries_(openEdges(mesh_)) {
  const auto isLocked = [&](uint32_t position) { return mesh_.lca_depth[position] < depth; };
  std::erase_if(boundaries_, [&](glm::u32vec2 edge) { return isLocked(edge.x) && isLocked(edge.y); });
  std::vector<glm::u32vec2> images;
  for (const ReferenceBoundary& reference : references_.boundaries)
    images.emplace_back(std::min(reference.near.x, reference.near.y),
                        std::max(reference.near.x, reference.near.y));
  std::sort(images.begin(), images.end(), isBefore);
  const auto first_image =
      std::stable_partition(boundaries_.begin(), boundaries_.end(), [&](glm::u32vec2 boundary) {
        return !std::binary_search(images.begin(), images.end(), boundary, isBefore);
      });
  own_ = static_cast<uint32_t>(first_image - boundaries_.begin());
}

ReferenceBoundary LodInput::reference(uint32_t number) const noexcept {
  if (number < references_.boundaries.size()) return references_.boundaries[number];
  const glm::u32vec2 boundary = boundaries_[number - references_.boundaries.size()];
  return {mesh_.positions[boundary.x], mesh_.positions[boundary.y], boundary};
}

const TriangleTree& LodInput::tree() const {
  std::call_once(tree_made_, [this] { tree_.emplace(mesh_); });
  return *tree_;
}

}  // namespace lode::ingest
