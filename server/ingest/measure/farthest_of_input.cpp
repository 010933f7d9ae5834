#include "server/ingest/measure/farthest_of_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "server/ingest/measure/farthest_in_triangle.h"
#include "server/ingest/mesh/mesh_edges.h"

namespace lode::ingest {
namespace {

// Of the largest distance so far: triangles that are nearer at corners and ridges are passed over. At 0.6
// three of 480 rungs came out too small, by up to 0.95; at 0.45 two of 7,000, by up to 0.98; at 0.35 none.
constexpr float kWorthInInput = 0.35f;

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

/// The distance of an edge from a rung where it may be farther than at its ends; 0 if no point of it is
/// farther than `enough` and its ends. Where the ends are beside triangles of the rung that meet at an angle,
/// the edge is farthest where it crosses the ridge between them: by a quarter of its length times that angle
/// more than its ends, at most. Otherwise the distance from a triangle is convex.
float ridgeDistance(const PointBeside& from, const PointBeside& to, std::span<const glm::vec3> rung_normals,
                    const RungSurface& surface, float enough) {
  const float high = std::max(from.distance, to.distance);
  if (high > enough || from.triangle == to.triangle) return 0;
  const glm::vec3 along = to.at - from.at, turn = rung_normals[from.triangle] - rung_normals[to.triangle];
  const float room = 4 * (enough - high);
  if (glm::dot(along, along) * glm::dot(turn, turn) <= room * room) return 0;
  const float across = std::sqrt(surface.squaredDistance(from.at, to.triangle));
  if (across <= enough) return 0;
  const float back = std::sqrt(surface.squaredDistance(to.at, from.triangle));
  if (back <= enough) return 0;
  const float parting = across - from.distance, closing = back - to.distance;
  const float share = std::clamp(parting / (parting + closing), 0.f, 1.f);
  const float walked = surface.walkFrom(from.at + share * along, from.triangle, enough).distance;
  return walked > enough ? walked : 0;
}

/// The edges of a mesh at whose ridges the distance from a rung is larger than some `enough`.
class FarEdges {
 public:
  FarEdges(const NodeMesh& input, std::span<const PointBeside> beside,
           std::span<const glm::vec3> rung_normals, const RungSurface& surface, float enough)
      : begin_(input.positions.size() + 1) {
    forEachEdge(input, [&](uint32_t lower, uint32_t upper, uint32_t) {
      const float found = ridgeDistance(beside[lower], beside[upper], rung_normals, surface, enough);
      if (found == 0) return;
      ++begin_[lower + 1];
      uppers_.push_back({upper, found});
    });
    for (size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  }

  /// The distance at an edge's ridge; 0 if it is not larger.
  float distance(uint32_t a, uint32_t b) const {
    const uint32_t lower = std::min(a, b), upper = std::max(a, b);
    for (uint32_t i = begin_[lower]; i < begin_[lower + 1]; ++i)
      if (uppers_[i].position == upper) return uppers_[i].distance;
    return 0;
  }

 private:
  struct Upper {
    uint32_t position;
    float distance;
  };
  std::vector<uint32_t> begin_;  ///< in uppers_, of the edges of each lower position
  std::vector<Upper> uppers_;
};

}  // namespace

float farthestOfInput(const SimplifiedMesh& rung, const NodeMesh& input, const RungSurface& surface,
                      std::span<const SurfaceWalk::Place> places, float known) {
  std::vector<PointBeside> beside;
  beside.reserve(input.positions.size());
  for (uint32_t i = 0; i < input.positions.size(); ++i) {
    const glm::vec3 at(unpackPosition(input.positions[i]));
    if (rung.became[i] != kVanished && places[i].distance <= known) {
      beside.push_back({at, places[i].distance, places[i].triangle});
    } else {
      const TriangleTree::Nearest nearest = surface.nearest(at, known);
      beside.push_back({at, nearest.distance, nearest.triangle});
      known = std::max(known, nearest.distance);
    }
  }
  const FarEdges edges(input, beside, normalsOf(rung.mesh), surface, kWorthInInput * known);
  FarthestInTriangle farthest(surface, known, known);
  for (const glm::u32vec3& t : input.triangles) {
    const uint32_t a = input.wedge_position[t.x], b = input.wedge_position[t.y],
                   c = input.wedge_position[t.z];
    const float high = std::max({beside[a].distance, beside[b].distance, beside[c].distance,
                                 edges.distance(a, b), edges.distance(b, c), edges.distance(c, a)});
    if (high > kWorthInInput * farthest.told()) farthest.look({beside[a], beside[b], beside[c]});
  }
  return farthest.largest();
}

}  // namespace lode::ingest
