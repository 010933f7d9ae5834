#include "server/ingest/simplify/far_points.h"

#include <algorithm>
#include <limits>

#include "server/ingest/mesh/four_triangles.h"

namespace lode::ingest {

void FarPoints::gatherPoints(uint32_t position, glm::dvec3 to) {
  const bool is_of_input = mesh_.positions[position].merged_at == 0;
  const auto add = [this](glm::vec3 at) {
    constexpr float kNothing = std::numeric_limits<float>::infinity();
    points_.push_back({at, kNothing, fourOf(kNothing)});
  };
  if (is_of_input && mesh_.point(position) != to) add(glm::vec3(mesh_.point(position)));
  const Kept& kept = kept_[position];
  for (uint32_t i = 0; i < kept.count; ++i) add(kept.points[i]);
}

float FarPoints::measure(const EdgeSurroundings& around, glm::dvec3 to) {
  points_.clear();
  gatherPoints(around.u(), to);
  gatherPoints(around.v(), to);
  if (points_.empty() || around.places().empty()) return 0;
  const FourVectors apex{glm::vec3(to)};
  for (const EdgeSurroundings::FourSides& sides : around.places()) {
    const FourTriangles triangles(FourVectors{}, sides.a - apex, sides.b - apex);
    for (Point& point : points_) {
      const Four found = triangles.squaredDistances(FourVectors(point.at) - apex);
      point.least = smaller(found, point.least);
    }
  }
  for (Point& point : points_)
    point.squared =
        std::min(std::min(point.least[0], point.least[1]), std::min(point.least[2], point.least[3]));
  return std::ranges::max(points_, {}, &Point::squared).squared;
}

void FarPoints::join(uint32_t position) {
  Kept& kept = kept_[position];
  kept.count = std::min(kMostKept, static_cast<uint32_t>(points_.size()));
  auto next = points_.begin();
  for (uint32_t i = 0; i < kept.count; ++i, ++next) {
    const auto farthest = std::ranges::max_element(next, points_.end(), {}, &Point::squared);
    kept.points[i] = farthest->at;
    std::rotate(next, farthest, farthest + 1);
  }
}

}  // namespace lode::ingest
