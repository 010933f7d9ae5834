#include "server/ingest/measure/lod_deviation.h"

#include <algorithm>
#include <cmath>

#include "server/ingest/measure/farthest_of_input.h"
#include "server/ingest/measure/farthest_of_lod.h"

namespace lode::ingest {
namespace {

// What may have been missed: by whole triangles; by points of the LOD, or where its input is reduced and off
// the same way as the LOD is off it; by samples of the original that were thinned out on their way up.
// docs/benchmarks.md (Errors) has the ratios of stored errors to found ones that they lead to.
constexpr float kPrecision = 1.021f, kPointMargin = 1.12f, kSampleMargin = 1.1f;
// LODs of whose samples nothing is believed, and all.
constexpr float kDoubtedTriangles = 4096, kBelievedTriangles = 16384;
constexpr float kBelievedSampleMargin = 1.3f;

float beliefInSamples(size_t triangles) {
  const float above = static_cast<float>(triangles) - kDoubtedTriangles;
  return std::clamp(above / (kBelievedTriangles - kDoubtedTriangles), 0.f, 1.f);
}

}  // namespace

float deviationOfReduced(float from_input, float off, float farthest_sample, size_t triangles) {
  const float from = kPointMargin * from_input;
  const float independent = std::max(kSampleMargin * farthest_sample, std::hypot(from, off));
  const float sampled = std::max({from, off, std::min(kBelievedSampleMargin * farthest_sample, independent)});
  return glm::mix(independent, sampled, beliefInSamples(triangles));
}

LodDeviation lodDeviation(const SimplifiedMesh& lod, const LodInput& input, const LodPlaces& places,
                          float farthest_sample) {
  const auto fromInput = [&](float known) {
    return farthestOfInput(lod, input.mesh(), places.surface, places.of_input, known);
  };
  const auto fromLod = [&](float known) {
    const float at_points = farthestOfLod(lod, input, places.of_input, places.sources, known);
    return lod.is_clustered ? farthestAlongEdges(lod, input, places.sources, at_points) : at_points;
  };
  if (input.isOriginal()) {
    const FarthestOfInput forward = fromInput(farthest_sample);
    const float steps = kPrecision * forward.steps;
    return {std::max(steps, kPointMargin * fromLod(steps / kPointMargin)), forward.inside};
  }
  const float sampled = kSampleMargin * farthest_sample, off = input.offSteps();
  const float known = std::sqrt(std::max(sampled * sampled - off * off, 0.f)) / kPointMargin;
  const float from_input = fromLod(fromInput(known).steps);
  return {deviationOfReduced(from_input, off, farthest_sample, lod.mesh.triangles.size()), {}};
}

}  // namespace lode::ingest
