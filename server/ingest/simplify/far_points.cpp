#include "server/ingest/simplify/far_points.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "server/ingest/mesh/four_triangles.h"

namespace lode::ingest {

void FarPoints::gatherPoints(uint32_t position, glm::dvec3 to) {
  const bool is_of_input = mesh_.positions[position].merged_at == 0;
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  if (is_of_input && mesh_.point(position) != to)
    points_.push_back({glm::vec3(mesh_.point(position)), kNothing});
  const Kept& kept = kept_[position];
  for (uint32_t i = 0; i < kept.count; ++i) points_.push_back({kept.points[i], kNothing});
}

void FarPoints::gatherTriangles(uint32_t position, uint32_t other, glm::vec3 to) {
  for (const uint32_t corner : mesh_.around(position)) {
    const uint32_t a = mesh_.at(CollapseMesh::next(corner)), b = mesh_.at(CollapseMesh::previous(corner));
    if (a == other || b == other) continue;
    sides_.push_back({glm::vec3(mesh_.point(a)) - to, glm::vec3(mesh_.point(b)) - to});
  }
}

float FarPoints::look(uint32_t u, uint32_t v, glm::dvec3 to) {
  points_.clear();
  sides_.clear();
  gatherPoints(u, to);
  gatherPoints(v, to);
  if (points_.empty()) return 0;
  const glm::vec3 apex(to);
  gatherTriangles(u, v, apex);
  gatherTriangles(v, u, apex);
  if (sides_.empty()) return 0;
  for (size_t i = 0; i < sides_.size(); i += 4) {
    const auto side = [&](size_t k) { return sides_[std::min(i + k, sides_.size() - 1)]; };
    const auto corners = [&](size_t end) {
      return FourVectors(side(0)[end], side(1)[end], side(2)[end], side(3)[end]);
    };
    const FourTriangles triangles(FourVectors{}, corners(0), corners(1));
    for (Point& point : points_) {
      const glm::vec3 at = point.at - apex;
      const Four found = triangles.squaredDistances({at, at, at, at});
      for (int k = 0; k < 4; ++k) point.squared = std::min(point.squared, found[k]);
    }
  }
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
