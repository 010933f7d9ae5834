#include "server/ingest/measure/surface_samples.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "server/ingest/mesh/number_table.h"

namespace lode::ingest {
namespace {

// Deviations below this share of the largest deviation need not be exact, because they only rank the samples.
constexpr float kRanks = 0.25f;
constexpr uint32_t kMostPointsInside = 64;  ///< largest number of points inside one triangle

uint64_t hashOf(const SurfaceSample& sample) noexcept { return NumberTable::hash(sample.position.value); }

glm::vec3 pointOf(const SurfaceSample& sample) noexcept { return glm::vec3(unpackPosition(sample.position)); }
glm::vec3 pointOf(const NodeMesh& mesh, uint32_t position) noexcept {
  return glm::vec3(unpackPosition(mesh.positions[position]));
}

/// Returns the barycentric weights of two corners for point n of a sequence that covers a triangle evenly.
/// Source: Roberts, The Unreasonable Effectiveness of Quasirandom Sequences, 2018 (its R2 sequence).
glm::vec2 sharesOf(uint32_t n) noexcept {
  const glm::vec2 square = glm::fract(static_cast<float>(n) * glm::vec2(0.7548777f, 0.5698403f));
  return square.x + square.y > 1 ? 1.f - square : square;
}

/// Returns the area that gets one point inside a triangle, in units of the mesh's mean triangle area.
double meansPerPoint(size_t triangles) noexcept { return triangles <= 1024 ? 0.5 : 2; }

/// Replaces distances that walks found by exact distances, the largest first, until the largest distance is
/// exact.
/// @param pointOf  returns the point that belongs to an index in `distances`.
template <typename PointOf>
void confirmLargest(const LodSurface& surface, std::vector<float>& distances, PointOf&& pointOf) {
  std::vector<uint32_t> order(distances.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto is_less = [&](uint32_t a, uint32_t b) { return distances[a] < distances[b]; };
  std::make_heap(order.begin(), order.end(), is_less);
  float largest = 0;
  while (!order.empty() && distances[order.front()] > largest) {
    std::pop_heap(order.begin(), order.end(), is_less);
    const uint32_t at = order.back();
    order.pop_back();
    const float walked = distances[at];
    distances[at] = surface.nearest(pointOf(at), 0, {walked * walked, walked, 0}).distance;
    largest = std::max(largest, distances[at]);
  }
}

}  // namespace

void selectSamples(std::vector<SurfaceSample>& samples, size_t positions, size_t capacity) {
  constexpr uint32_t kNone = UINT32_MAX;
  std::vector<uint32_t> order(samples.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto goes_first = [&](uint32_t a, uint32_t b) {
    if (samples[a].deviation != samples[b].deviation) return samples[a].deviation > samples[b].deviation;
    return std::pair(hashOf(samples[a]), a) < std::pair(hashOf(samples[b]), b);
  };
  std::vector<uint32_t> worst(positions, kNone);
  for (uint32_t i = 0; i < samples.size(); ++i) {
    if (samples[i].near == kVanished) continue;
    uint32_t& of_position = worst[samples[i].near];
    if (of_position == kNone || goes_first(i, of_position)) of_position = i;
  }
  std::vector<bool> is_kept(samples.size());
  for (const uint32_t i : worst)
    if (i != kNone) is_kept[i] = true;
  const auto others = std::partition(order.begin(), order.end(), [&](uint32_t i) { return is_kept[i]; });
  const auto room = static_cast<ptrdiff_t>(capacity) - (others - order.begin());
  const auto end = others + std::clamp<ptrdiff_t>(room, 0, order.end() - others);
  if (end != order.end()) std::nth_element(others, end, order.end(), goes_first);
  for (auto kept = others; kept != end; ++kept) is_kept[*kept] = true;
  size_t count = 0;
  for (size_t i = 0; i < samples.size(); ++i)
    if (is_kept[i]) samples[count++] = samples[i];
  samples.resize(count);
}

void addLockedPositions(std::vector<SurfaceSample>& samples, const NodeMesh& mesh, int depth) {
  for (uint32_t i = 0; i < mesh.positions.size(); ++i)
    if (mesh.lca_depth[i] < depth) samples.push_back({mesh.positions[i], 0, i});
}

void dropDuplicates(std::vector<SurfaceSample>& samples) {
  std::sort(samples.begin(), samples.end(), [](const SurfaceSample& a, const SurfaceSample& b) {
    return std::tie(a.position, a.near, b.deviation) < std::tie(b.position, b.near, a.deviation);
  });
  const auto is_same = [](const SurfaceSample& a, const SurfaceSample& b) {
    return a.position == b.position && a.near == b.near;
  };
  samples.erase(std::unique(samples.begin(), samples.end(), is_same), samples.end());
}

std::vector<SurfaceWalk::Place> placesOn(const SimplifiedMesh& lod, const NodeMesh& input,
                                         const SurfaceWalk& walk) {
  std::vector<SurfaceWalk::Place> places(input.positions.size());
  for (uint32_t i = 0; i < places.size(); ++i) {
    const uint32_t image = lod.remap[i];
    if (image == kVanished) continue;
    const bool has_stayed = lod.mesh.positions[image] == input.positions[i];
    places[i] = has_stayed ? walk.placeAt(image) : walk.placeOf(pointOf(input, i), image);
  }
  return places;
}

std::vector<Deviation> deviationsFrom(const SimplifiedMesh& lod, const NodeMesh& input,
                                      const LodSurface& surface, std::span<const SurfaceWalk::Place> places,
                                      std::span<const SurfaceSample> samples) {
  std::vector<float> distances;
  std::vector<uint32_t> nears;
  distances.reserve(samples.size());
  nears.reserve(samples.size());
  float largest = 0;
  for (const SurfaceSample& sample : samples) {
    uint32_t near = sample.near == kVanished ? kVanished : lod.remap[sample.near];
    if (near == kVanished) {  // the triangles around the position have vanished: use the nearest remaining
                              // triangle
      const TriangleTree::Nearest found = surface.nearest(pointOf(sample), kRanks * largest);
      near = lod.mesh.wedge_position[lod.mesh.triangles[found.triangle].x];
      distances.push_back(found.distance);
    } else if (sample.position == input.positions[sample.near]) {
      distances.push_back(places[sample.near].distance);
    } else {
      const uint32_t beside = places[sample.near].triangle;
      distances.push_back(surface.walkFrom(pointOf(sample), beside, kRanks * largest).distance);
    }
    nears.push_back(near);
    largest = std::max(largest, distances.back());
  }
  confirmLargest(surface, distances, [&](size_t i) { return pointOf(samples[i]); });
  std::vector<Deviation> deviations;
  deviations.reserve(samples.size());
  for (size_t i = 0; i < samples.size(); ++i) deviations.push_back({distances[i], nears[i]});
  return deviations;
}

std::vector<SurfaceSample> samplesInside(const NodeMesh& mesh) {
  std::vector<float> areas;
  double total = 0;
  for (const glm::u32vec3& t : mesh.triangles) {
    const glm::vec3 a = pointOf(mesh, mesh.wedge_position[t.x]);
    areas.push_back(glm::length(glm::cross(pointOf(mesh, mesh.wedge_position[t.y]) - a,
                                           pointOf(mesh, mesh.wedge_position[t.z]) - a)));
    total += areas.back();
  }
  if (total == 0) return {};
  const double area_of_point = meansPerPoint(areas.size()) * total / static_cast<double>(areas.size());
  std::vector<SurfaceSample> samples;
  for (size_t i = 0; i < areas.size(); ++i) {
    if (areas[i] < area_of_point) continue;
    const glm::u32vec3& t = mesh.triangles[i];
    const glm::vec3 a = pointOf(mesh, mesh.wedge_position[t.x]),
                    ab = pointOf(mesh, mesh.wedge_position[t.y]) - a,
                    ac = pointOf(mesh, mesh.wedge_position[t.z]) - a;
    const auto count = static_cast<uint32_t>(std::min<double>(areas[i] / area_of_point, kMostPointsInside));
    for (uint32_t n = 1; n <= count; ++n) {
      const glm::vec2 shares = sharesOf(n);
      const glm::vec3 point = glm::round(a + shares.x * ab + shares.y * ac);
      samples.push_back({packPosition(glm::uvec3(point)), 0, mesh.wedge_position[t.x]});
    }
  }
  return samples;
}

}  // namespace lode::ingest
