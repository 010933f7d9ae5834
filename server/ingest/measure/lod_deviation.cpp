#include "server/ingest/measure/lod_deviation.h"

#include <algorithm>
#include <cmath>

#include "server/ingest/measure/farthest_of_input.h"
#include "server/ingest/measure/farthest_of_lod.h"

namespace lode::ingest {
namespace {

// Safety factors. kPrecision covers skipped triangles. kPointMargin covers points between the sampled points
// of an LOD, and LODs that deviate in the same direction as their input. kSampleMargin covers dropped
// samples. docs/benchmarks.md (Errors) has the resulting ratios of stored to measured errors.
constexpr float kPrecision = 1.021f, kPointMargin = 1.12f, kSampleMargin = 1.1f;
// Samples do not lower the result for LODs of up to kUntrustedTriangles triangles. They have their full
// effect from kTrustedTriangles triangles on.
constexpr float kUntrustedTriangles = 4096, kTrustedTriangles = 16384;
constexpr float kTrustedSampleMargin = 1.3f;

float trustInSamples(size_t triangles) {
  const float above = static_cast<float>(triangles) - kUntrustedTriangles;
  return std::clamp(above / (kTrustedTriangles - kUntrustedTriangles), 0.f, 1.f);
}

}  // namespace

float deviationOfReduced(float from_input, float off, float farthest_sample, size_t triangles) {
  const float from = kPointMargin * from_input;
  const float independent = std::max(kSampleMargin * farthest_sample, std::hypot(from, off));
  const float sampled = std::max({from, off, std::min(kTrustedSampleMargin * farthest_sample, independent)});
  return glm::mix(independent, sampled, trustInSamples(triangles));
}

LodDeviation lodDeviation(const SimplifiedMesh& lod, const LodInput& input, const LodPlaces& places,
                          float farthest_sample) {
  const auto fromInput = [&](float lower_bound) {
    return farthestOfInput(lod, input.mesh(), places.surface, places.of_input, lower_bound);
  };
  const auto fromLod = [&](float lower_bound) {
    const float at_points = farthestOfLod(lod, input, places.of_input, places.sources, lower_bound);
    return lod.is_clustered ? farthestAlongEdges(lod, input, places.sources, at_points) : at_points;
  };
  if (input.isOriginal()) {
    const FarthestOfInput forward = fromInput(farthest_sample);
    const float steps = kPrecision * forward.steps;
    return {std::max(steps, kPointMargin * fromLod(steps / kPointMargin)), forward.inside};
  }
  const float sampled = kSampleMargin * farthest_sample, off = input.offSteps();
  const float lower_bound = std::sqrt(std::max(sampled * sampled - off * off, 0.f)) / kPointMargin;
  const float from_input = fromLod(fromInput(lower_bound).steps);
  return {deviationOfReduced(from_input, off, farthest_sample, lod.mesh.triangles.size()), {}};
}

}  // namespace lode::ingest
