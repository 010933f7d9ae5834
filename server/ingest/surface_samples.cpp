#include "server/ingest/surface_samples.h"

#include <algorithm>

#include "server/ingest/number_table.h"

namespace lode::ingest {
namespace {

uint64_t hashOf(const SurfaceSample& sample) noexcept { return NumberTable::hash(sample.position.value); }

}  // namespace

std::vector<SurfaceSample> samplesOf(const NodeMesh& leaf) {
  std::vector<SurfaceSample> samples;
  samples.reserve(leaf.positions.size());
  for (const PositionCode position : leaf.positions) samples.push_back({position, 0});
  return samples;
}

void selectSamples(std::vector<SurfaceSample>& samples, size_t capacity) {
  std::sort(samples.begin(), samples.end(), [](const SurfaceSample& a, const SurfaceSample& b) {
    return a.position != b.position ? a.position < b.position : a.deviation > b.deviation;
  });
  samples.erase(
      std::unique(samples.begin(), samples.end(),
                  [](const SurfaceSample& a, const SurfaceSample& b) { return a.position == b.position; }),
      samples.end());
  if (samples.size() <= capacity) return;
  const auto by_hash = [](const SurfaceSample& a, const SurfaceSample& b) { return hashOf(a) < hashOf(b); };
  const auto by_deviation = [](const SurfaceSample& a, const SurfaceSample& b) {
    return a.deviation != b.deviation ? a.deviation > b.deviation : hashOf(a) < hashOf(b);
  };
  const auto half = samples.begin() + static_cast<ptrdiff_t>(capacity / 2);
  std::nth_element(samples.begin(), half, samples.end(), by_deviation);
  std::nth_element(half, samples.begin() + static_cast<ptrdiff_t>(capacity), samples.end(), by_hash);
  samples.resize(capacity);
}

float measureDeviation(const NodeMesh& rung, std::vector<SurfaceSample>& samples) {
  const TriangleGrid grid(rung);
  float largest = 0;
  for (SurfaceSample& sample : samples) {
    const float distance = grid.distance(sample.position);
    largest = std::max(largest, distance);
    sample.deviation = std::max(sample.deviation, distance);
  }
  return largest;
}

float farthestVertex(const NodeMesh& rung, const TriangleGrid& input) {
  float largest = 0;
  for (const PositionCode position : rung.positions) largest = std::max(largest, input.distance(position));
  return largest;
}

}  // namespace lode::ingest
