#include "server/ingest/surface_samples.h"

#include <algorithm>
#include <optional>

#include "server/ingest/number_table.h"
#include "server/ingest/triangle_grid.h"

namespace lode::ingest {
namespace {

// Deviations below this share of the largest need not be exact: they only rank samples.
constexpr float kRanks = 0.25f;
constexpr int kMostConfirmed = 32;

uint64_t hashOf(const SurfaceSample& sample) noexcept { return NumberTable::hash(sample.position.value); }

/// Makes the largest of the distances that walks have found exact, as long as that takes few looks.
/// @param pointOf  the point of each distance. @return the largest.
template <typename PointOf>
float confirmLargest(const SurfaceWalk& walk, std::vector<float>& distances, PointOf&& pointOf) {
  std::vector<bool> exact(distances.size());
  for (int looks = 0;; ++looks) {
    const auto largest = std::max_element(distances.begin(), distances.end());
    const auto at = static_cast<size_t>(largest - distances.begin());
    if (largest == distances.end()) return 0;
    if (exact[at] || looks == kMostConfirmed) return *largest;
    *largest = walk.exactDistance(pointOf(at), *largest);
    exact[at] = true;
  }
}

}  // namespace

void selectSamples(std::vector<SurfaceSample>& samples, size_t capacity) {
  if (samples.size() <= capacity) return;
  std::vector<uint32_t> order(samples.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto by_deviation = [&](uint32_t a, uint32_t b) {
    return samples[a].deviation != samples[b].deviation ? samples[a].deviation > samples[b].deviation
                                                        : hashOf(samples[a]) < hashOf(samples[b]);
  };
  const auto by_hash = [&](uint32_t a, uint32_t b) { return hashOf(samples[a]) < hashOf(samples[b]); };
  const auto half = order.begin() + static_cast<ptrdiff_t>(capacity / 2);
  const auto end = order.begin() + static_cast<ptrdiff_t>(capacity);
  std::nth_element(order.begin(), half, order.end(), by_deviation);
  std::nth_element(half, end, order.end(), by_hash);
  std::sort(order.begin(), end);
  for (size_t i = 0; i < capacity; ++i) samples[i] = samples[order[i]];
  samples.resize(capacity);
}

void dropDuplicates(std::vector<SurfaceSample>& samples) {
  std::sort(samples.begin(), samples.end(), [](const SurfaceSample& a, const SurfaceSample& b) {
    return a.position != b.position ? a.position < b.position : a.deviation > b.deviation;
  });
  samples.erase(
      std::unique(samples.begin(), samples.end(),
                  [](const SurfaceSample& a, const SurfaceSample& b) { return a.position == b.position; }),
      samples.end());
}

float measureDeviation(const SimplifiedMesh& rung, const SurfaceWalk& walk,
                       std::vector<SurfaceSample>& samples) {
  std::optional<TriangleGrid> grid;  // where nothing is known to be near
  std::vector<float> distances;
  distances.reserve(samples.size());
  float largest = 0;
  for (const SurfaceSample& sample : samples) {
    const uint32_t start = sample.near == kVanished ? kVanished : rung.became[sample.near];
    if (start == kVanished && !grid) grid.emplace(rung.mesh);
    distances.push_back(start == kVanished ? grid->distance(sample.position)
                                           : walk.distance(sample.position, start, kRanks * largest));
    largest = std::max(largest, distances.back());
  }
  largest = confirmLargest(walk, distances, [&](size_t i) { return samples[i].position; });
  for (size_t i = 0; i < samples.size(); ++i)
    samples[i].deviation = std::max(samples[i].deviation, distances[i]);
  return largest;
}

float farthestVertex(const SimplifiedMesh& rung, std::span<const uint32_t> sources, const SurfaceWalk& walk) {
  std::vector<float> distances;
  distances.reserve(sources.size());
  float largest = 0;
  for (size_t i = 0; i < sources.size(); ++i) {
    distances.push_back(walk.distance(rung.mesh.positions[i], sources[i], largest));
    largest = std::max(largest, distances.back());
  }
  return confirmLargest(walk, distances, [&](size_t i) { return rung.mesh.positions[i]; });
}

}  // namespace lode::ingest
