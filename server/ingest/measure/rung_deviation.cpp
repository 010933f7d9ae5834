#include "server/ingest/measure/rung_deviation.h"

#include <algorithm>
#include <cmath>

#include "server/ingest/measure/farthest_of_input.h"
#include "server/ingest/measure/farthest_of_rung.h"

namespace lode::ingest {
namespace {

// What may have been missed: by whole triangles; by points of the rung, or where its input is reduced and off
// the same way as the rung is off it; by samples of the original that were thinned out on their way up.
// docs/benchmarks.md (Errors) has the ratios of stored errors to found ones that they lead to.
constexpr float kPrecision = 1.021f, kPointMargin = 1.12f, kSampleMargin = 1.1f;

}  // namespace

float rungDeviation(const SimplifiedMesh& rung, const RungInput& input, const RungPlaces& places,
                    float farthest_sample) {
  const auto fromInput = [&](float known) {
    return farthestOfInput(rung, input.mesh(), places.surface, places.of_input, known);
  };
  const auto fromRung = [&](float known) {
    return farthestOfRung(rung, input, places.of_input, places.sources, known);
  };
  if (input.isOriginal()) {
    const float forward = kPrecision * fromInput(farthest_sample);
    return std::max(forward, kPointMargin * fromRung(forward / kPointMargin));
  }
  const float sampled = kSampleMargin * farthest_sample, off = input.offSteps();
  const float known = std::sqrt(std::max(sampled * sampled - off * off, 0.f)) / kPointMargin;
  return std::max(sampled, std::hypot(kPointMargin * fromRung(fromInput(known)), off));
}

}  // namespace lode::ingest
