#include "server/ingest/measure/reference_boundaries.h"

#include "server/ingest/measure/lod_input.h"

namespace lode::ingest {

glm::u32vec2 imageOf(glm::u32vec2 ends, std::span<const uint32_t> became) noexcept {
  const auto imageOfEnd = [&](uint32_t end) { return end == kVanished ? kVanished : became[end]; };
  return {imageOfEnd(ends.x), imageOfEnd(ends.y)};
}

ReferenceBoundaries referencesIn(const LodInput& input, std::span<const uint32_t> became,
                                 float boundary_gap_steps, size_t most) {
  ReferenceBoundaries references{{}, input.referenceGapSteps()};
  for (uint32_t i = 0; i < input.referenceCount(); ++i) {
    ReferenceBoundary reference = input.reference(i);
    reference.near = imageOf(reference.near, became);
    if (reference.near == glm::u32vec2(kVanished)) continue;
    if (references.boundaries.size() == most) return {{}, boundary_gap_steps};
    references.boundaries.push_back(reference);
  }
  return references;
}

}  // namespace lode::ingest
