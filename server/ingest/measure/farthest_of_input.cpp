#include "server/ingest/measure/farthest_of_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "server/ingest/measure/farthest_in_triangle.h"
#include "server/ingest/measure/triangle_tree.h"

namespace lode::ingest {
namespace {

// Of the largest distance so far: triangles that are nearer at corners and ridges are passed over. At 0.6
// three of 480 rungs came out too small, by up to 0.95; at 0.45 none, as if all triangles were looked at.
constexpr float kWorth = 0.45f;

/// A rung, for FarthestInTriangle: by walks, and where these lead too far by a tree, which few rungs need.
class RungSurface {
 public:
  RungSurface(const NodeMesh& rung, const SurfaceWalk& walk) : rung_(rung), walk_(walk) {}

  float squaredDistance(glm::vec3 at, uint32_t triangle) const noexcept {
    return walk_.squaredDistance(at, triangle);
  }
  PointBeside measure(glm::vec3 at, uint32_t hint, float enough) const {
    const float squared = walk_.squaredDistance(at, hint);
    if (squared <= enough * enough) return {at, std::sqrt(squared), hint};
    const float walked = walk_.distanceFrom(at, hint, enough);
    if (walked <= enough) return {at, walked, hint};
    return measureExactly(at, enough, {walked * walked, walked, hint});
  }
  PointBeside measureExactly(glm::vec3 at, float enough,
                             TriangleTree::Nearest known = TriangleTree::kNothing) const {
    if (!tree_) tree_.emplace(rung_);
    const TriangleTree::Nearest nearest = tree_->nearest(at, enough, known);
    return {at, nearest.distance, nearest.triangle};
  }

 private:
  const NodeMesh& rung_;
  const SurfaceWalk& walk_;
  mutable std::optional<TriangleTree> tree_;
};

std::vector<glm::vec3> normalsOf(const NodeMesh& mesh) {
  std::vector<glm::vec3> normals;
  normals.reserve(mesh.triangles.size());
  const auto corner = [&](uint32_t wedge) {
    return glm::vec3(unpackPosition(mesh.positions[mesh.wedge_position[wedge]]));
  };
  for (const glm::u32vec3& t : mesh.triangles) {
    const glm::vec3 a = corner(t.x), normal = glm::cross(corner(t.y) - a, corner(t.z) - a);
    const float length = glm::length(normal);
    normals.push_back(length > 0 ? normal / length : glm::vec3(0));
  }
  return normals;
}

/// Whether some point of a triangle may be as far from a rung as `worth`. Where its corners are beside
/// triangles of the rung that meet at an angle, the triangle is farthest where it crosses the ridge between
/// them: by a quarter of its edge times that angle more than its corners, at most. That point is looked at.
bool isWorthALook(const std::array<PointBeside, 3>& corners, std::span<const glm::vec3> rung_normals,
                  const RungSurface& surface, float worth) {
  for (size_t k = 0; k < 3; ++k) {
    const PointBeside &from = corners[k], &to = corners[(k + 1) % 3];
    const float high = std::max(from.distance, to.distance);
    if (high > worth) return true;
    if (from.triangle == to.triangle) continue;
    const float angle = glm::distance(rung_normals[from.triangle], rung_normals[to.triangle]);
    if (high + glm::distance(from.at, to.at) * angle / 4 <= worth) continue;
    const float parting = std::sqrt(surface.squaredDistance(from.at, to.triangle)) - from.distance;
    const float closing = std::sqrt(surface.squaredDistance(to.at, from.triangle)) - to.distance;
    const float share = parting + closing > 0 ? std::clamp(parting / (parting + closing), 0.f, 1.f) : 0.5f;
    if (surface.measure(glm::mix(from.at, to.at, share), from.triangle, worth).distance > worth) return true;
  }
  return false;
}

}  // namespace

float farthestOfInput(const SimplifiedMesh& rung, const NodeMesh& input, const SurfaceWalk& walk,
                      std::span<const SurfaceWalk::Place> places, float known) {
  const RungSurface surface(rung.mesh, walk);
  const std::vector<glm::vec3> normals = normalsOf(rung.mesh);
  FarthestInTriangle farthest(surface, known, known);
  const auto corner = [&](uint32_t wedge) -> PointBeside {
    const uint32_t position = input.wedge_position[wedge];
    const glm::vec3 at(unpackPosition(input.positions[position]));
    const SurfaceWalk::Place& place = places[position];
    const bool is_known = rung.became[position] != kVanished && place.distance <= farthest.told();
    return is_known ? PointBeside{at, place.distance, place.triangle}
                    : surface.measureExactly(at, farthest.told());
  };
  for (const glm::u32vec3& t : input.triangles) {
    const std::array<PointBeside, 3> corners{corner(t.x), corner(t.y), corner(t.z)};
    if (isWorthALook(corners, normals, surface, kWorth * farthest.told())) farthest.look(corners);
  }
  return farthest.largest();
}

}  // namespace lode::ingest
