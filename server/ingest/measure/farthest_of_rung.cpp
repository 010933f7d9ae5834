#include "server/ingest/measure/farthest_of_rung.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace lode::ingest {
namespace {

constexpr float kWorth = 0.8f;  ///< of the largest distance so far: triangles that reach it get a closer look
// Steps along each edge at first: the fewer triangles a rung has, the more may hide inside one of them, and
// the less a look costs. (Corners alone found 0.8 of what large rungs of a gyroid are off by.)
constexpr size_t kFewTriangles = 1024;
constexpr uint32_t stepsAtFirst(size_t triangles) { return triangles <= kFewTriangles ? 4 : 2; }
constexpr float kManySteps = 1.5f;  ///< for each edge of the input that an edge of the rung is as long as
constexpr uint32_t kMostSteps = 24;
constexpr int kMostLooks = 32;  ///< at every triangle of the input, before its tree is asked

class Measurement {
 public:
  Measurement(const SimplifiedMesh& rung, const RungInput& input, std::span<const uint32_t> sources,
              float known)
      : mesh_(rung.mesh), input_(input), sources_(sources), largest_(known) {}

  float run() {
    of_vertex_.reserve(sources_.size());
    for (uint32_t i = 0; i < sources_.size(); ++i) {
      uint32_t near = sources_[i];
      of_vertex_.push_back(measure(pointOf(i), near, kWorth * largest_));
    }
    std::vector<float> high;
    high.reserve(mesh_.triangles.size());
    const uint32_t few = stepsAtFirst(mesh_.triangles.size());
    for (const glm::u32vec3& t : mesh_.triangles) high.push_back(look(t, few, kWorth));
    const auto steps = static_cast<uint32_t>(kManySteps * edgesOfInputAlongEdge());
    for (size_t t = 0; t < high.size(); ++t)
      if (high[t] > kWorth * largest_) look(mesh_.triangles[t], std::clamp(steps, 2 * few, kMostSteps), 1);
    return largest_;
  }

 private:
  glm::vec3 pointOf(uint32_t position) const { return glm::vec3(unpackPosition(mesh_.positions[position])); }

  float edgesOfInputAlongEdge() const {
    return std::sqrt(static_cast<float>(input_.mesh().triangles.size()) /
                     static_cast<float>(std::max<size_t>(1, mesh_.triangles.size())));
  }

  /// @param near  where a walk over the input begins; becomes where it has ended.
  /// @param enough  up to which the distance need not be exact.
  float measure(glm::vec3 point, uint32_t& near, float enough) {
    const float walked = input_.walk().distanceOnwards(point, near, enough);
    if (walked <= largest_) return walked;
    const float exact = looks_++ < kMostLooks
                            ? input_.walk().exactDistance(point, walked)
                            : input_.tree().nearest(point, 0, {walked * walked, walked, 0}).distance;
    largest_ = std::max(largest_, exact);
    return exact;
  }

  /// @param steps  into which edges are divided, and the triangle with them.
  /// @param enough  of the largest distance so far.
  /// @return the largest distance of its points.
  float look(const glm::u32vec3& triangle, uint32_t steps, float enough) {
    const glm::u32vec3 at(mesh_.wedge_position[triangle.x], mesh_.wedge_position[triangle.y],
                          mesh_.wedge_position[triangle.z]);
    const glm::vec3 a = pointOf(at.x), b = pointOf(at.y), c = pointOf(at.z);
    float high = std::max({of_vertex_[at.x], of_vertex_[at.y], of_vertex_[at.z]});
    uint32_t near_row = sources_[at.z];  // where walks to the points of a row begin
    for (uint32_t i = 0; i < steps; ++i) {
      uint32_t near = near_row;
      for (uint32_t j = 0; i + j <= steps; ++j) {
        const uint32_t k = steps - i - j;
        const bool is_corner = j == steps || k == steps;
        if (is_corner) continue;
        const glm::vec3 sum =
            static_cast<float>(i) * a + static_cast<float>(j) * b + static_cast<float>(k) * c;
        high = std::max(high, measure(sum / static_cast<float>(steps), near, enough * largest_));
        if (j == 0) near_row = near;
      }
    }
    return high;
  }

  const NodeMesh& mesh_;
  const RungInput& input_;
  const std::span<const uint32_t> sources_;
  float largest_;
  int looks_ = 0;
  std::vector<float> of_vertex_;
};

}  // namespace

float farthestOfRung(const SimplifiedMesh& rung, const RungInput& input, std::span<const uint32_t> sources,
                     float known) {
  return Measurement(rung, input, sources, known).run();
}

}  // namespace lode::ingest
