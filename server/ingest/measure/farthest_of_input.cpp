#include "server/ingest/measure/farthest_of_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "server/ingest/measure/farthest_in_triangle.h"

namespace lode::ingest {
namespace {

// A triangle is skipped if its estimated distance is below this share of the largest distance so far.
constexpr float kRefineAboveInInput = 0.7f;

/// Plane of a triangle; the normal is 0 if the triangle has no area.
struct Plane {
  glm::vec3 normal, at;

  float height(glm::vec3 point) const noexcept { return glm::dot(normal, point - at); }
};

std::vector<Plane> planesOf(const NodeMesh& mesh) {
  std::vector<Plane> planes;
  planes.reserve(mesh.triangles.size());
  const auto corner = [&](uint32_t wedge) {
    return glm::vec3(unpackPosition(mesh.positions[mesh.wedge_position[wedge]]));
  };
  for (const glm::u32vec3& t : mesh.triangles) {
    const glm::vec3 a = corner(t.x), normal = glm::cross(corner(t.y) - a, corner(t.z) - a);
    const float length = glm::length(normal);
    planes.push_back({length > 0 ? normal / length : glm::vec3(0), a});
  }
  return planes;
}

/// Estimates the largest distance from a triangle of the input to an LOD. The estimate is usually too large.
class TriangleEstimate {
 public:
  TriangleEstimate(const NodeMesh& lod, const LodSurface& surface)
      : lod_(lod), surface_(surface), planes_(planesOf(lod)) {}

  float operator()(const std::array<MeasuredPoint, 3>& corners) const {
    float most = 0;
    for (size_t k = 0; k < 3; ++k)
      most = std::max({most, corners[k].distance, distanceOfSide(corners[k], corners[(k + 1) % 3])});
    return most;
  }

 private:
  /// Estimates how far a side is from the LOD: measures from each end to the plane of the LOD triangle
  /// nearest to the other end, and takes the smaller distance. If these two triangles do not touch, the LOD
  /// may have a gap between them through which both planes pass. The function then measures to the triangles
  /// instead of their planes.
  float distanceOfSide(const MeasuredPoint& from, const MeasuredPoint& to) const {
    const float of_planes = std::min(std::abs(planes_[to.triangle].height(from.at)),
                                     std::abs(planes_[from.triangle].height(to.at)));
    if (doTouch(from.triangle, to.triangle)) return of_planes;
    return std::sqrt(std::min(surface_.squaredDistance(from.at, to.triangle),
                              surface_.squaredDistance(to.at, from.triangle)));
  }

  bool doTouch(uint32_t a, uint32_t b) const {
    const glm::u32vec3 p = positionsOf(a), q = positionsOf(b);
    return glm::any(glm::equal(p, q)) || glm::any(glm::equal(p, {q.y, q.z, q.x})) ||
           glm::any(glm::equal(p, {q.z, q.x, q.y}));
  }

  glm::u32vec3 positionsOf(uint32_t triangle) const {
    const glm::u32vec3& t = lod_.triangles[triangle];
    return {lod_.wedge_position[t.x], lod_.wedge_position[t.y], lod_.wedge_position[t.z]};
  }

  const NodeMesh& lod_;
  const LodSurface& surface_;
  const std::vector<Plane> planes_;
};

/// Measures the distance from each position of the input to the LOD. A distance need not be exact if it is at
/// most `lower_bound`. Raises `lower_bound` to the largest distance.
std::vector<MeasuredPoint> measurePositions(const SimplifiedMesh& lod, const NodeMesh& input,
                                            const LodSurface& surface,
                                            std::span<const SurfaceWalk::Place> places, float& lower_bound) {
  std::vector<MeasuredPoint> beside;
  beside.reserve(input.positions.size());
  for (uint32_t i = 0; i < input.positions.size(); ++i) {
    const glm::vec3 at(unpackPosition(input.positions[i]));
    if (lod.remap[i] != kVanished && places[i].distance <= lower_bound) {
      beside.push_back({at, places[i].distance, places[i].triangle});
    } else {
      const TriangleTree::Nearest nearest = surface.nearest(at, lower_bound);
      beside.push_back({at, nearest.distance, nearest.triangle});
      lower_bound = std::max(lower_bound, nearest.distance);
    }
  }
  return beside;
}

}  // namespace

FarthestOfInput farthestOfInput(const SimplifiedMesh& lod, const NodeMesh& input, const LodSurface& surface,
                                std::span<const SurfaceWalk::Place> places, float lower_bound) {
  const std::vector<MeasuredPoint> beside = measurePositions(lod, input, surface, places, lower_bound);
  const TriangleEstimate estimate(lod.mesh, surface);
  FarthestInTriangle farthest(surface, lower_bound, lower_bound);
  uint32_t corner = 0;  // a corner of the triangle that contains the farthest point
  for (const glm::u32vec3& t : input.triangles) {
    const MeasuredPoint &a = beside[input.wedge_position[t.x]], &b = beside[input.wedge_position[t.y]],
                        &c = beside[input.wedge_position[t.z]];
    // If all corners have the same nearest triangle, a corner is the farthest point.
    if (a.triangle == b.triangle && b.triangle == c.triangle) continue;
    const std::array<MeasuredPoint, 3> corners{a, b, c};
    if (estimate(corners) <= kRefineAboveInInput * farthest.precision()) continue;
    const float before = farthest.largest();
    farthest.process(corners);
    if (farthest.largest() > before) corner = input.wedge_position[t.x];
  }
  FarthestOfInput found{farthest.largest(), {}};
  if (farthest.at())
    found.inside = SurfaceSample{packPosition(glm::uvec3(glm::round(*farthest.at()))), found.steps, corner};
  return found;
}

}  // namespace lode::ingest
