#include "server/ingest/triangulate.h"

#include <algorithm>
#include <cmath>

namespace lode::ingest {
namespace {

/// Twice the signed area.
double cross(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// How much an ear may lack before it is cut. A simple polygon needs no more than kFlat.
enum Tolerance { kStrict, kTouching, kFlat, kConvex, kAny };

/// A polygon in the coordinate plane that shows most of it, counter-clockwise there, of size about 1.
class Outline {
 public:
  explicit Outline(std::span<const glm::dvec3> corners) : size_(static_cast<uint32_t>(corners.size())) {
    points_.resize(size_);
    double extent = 0;
    for (const glm::dvec3& corner : corners) {
      const glm::dvec3 relative = corner - corners[0];
      extent = std::max({extent, std::fabs(relative.x), std::fabs(relative.y), std::fabs(relative.z)});
    }
    if (!(extent > 0) || !std::isfinite(extent)) return;  // all points at 0: every ear is as good
    glm::dvec3 normal(0);                                 // Newell's method
    glm::dvec3 last = (corners.back() - corners[0]) / extent;
    for (const glm::dvec3& corner : corners) {
      const glm::dvec3 here = (corner - corners[0]) / extent;
      normal += glm::cross(last, here);
      last = here;
    }
    const glm::dvec3 size = glm::abs(normal);
    const int dropped = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
    const bool backwards = normal[dropped] < 0;
    const int u = (dropped + (backwards ? 2 : 1)) % 3;
    const int v = (dropped + (backwards ? 1 : 2)) % 3;
    for (uint32_t i = 0; i < size_; ++i) {
      const glm::dvec3 here = (corners[i] - corners[0]) / extent;
      points_[i] = {here[u], here[v]};
    }
  }

  double area(uint32_t a, uint32_t b, uint32_t c) const { return cross(points_[a], points_[b], points_[c]); }

  void clip(std::vector<glm::u32vec3>& triangles) {
    link();
    uint32_t corner = 0;
    uint32_t failures = 0;
    int tolerance = kStrict;
    for (uint32_t left = size_; left > 3;) {
      if (isEar(corner, budget_ > 0 ? tolerance : kAny)) {
        const uint32_t before = before_[corner];
        const uint32_t after = after_[corner];
        triangles.emplace_back(before, corner, after);
        after_[before] = after;
        before_[after] = before;
        removed_[corner] = true;
        --left;
        failures = 0;
        tolerance = kStrict;
        corner = after_[after];  // not the same corner again: that would give a fan
      } else {
        corner = after_[corner];
        if (++failures >= left) {
          failures = 0;
          ++tolerance;
        }
      }
      if (left == 3) triangles.emplace_back(before_[corner], corner, after_[corner]);
    }
  }

 private:
  void link() {
    before_.resize(size_);
    after_.resize(size_);
    removed_.assign(size_, false);
    for (uint32_t i = 0; i < size_; ++i) {
      before_[i] = i == 0 ? size_ - 1 : i - 1;
      after_[i] = i + 1 == size_ ? 0 : i + 1;
    }
    for (uint32_t i = 0; i < size_; ++i) {
      if (!(area(before_[i], i, after_[i]) > 0)) reflex_.push_back(i);
    }
    budget_ = std::max<int64_t>(kLeastBudget, int64_t{size_} * kBudgetPerCorner);
  }

  /// Only reflex corners can lie in an ear.
  bool isEar(uint32_t corner, int tolerance) {
    if (tolerance == kAny) return true;
    const uint32_t before = before_[corner];
    const uint32_t after = after_[corner];
    const double ear_area = area(before, corner, after);
    if (tolerance >= kFlat ? !(ear_area >= 0) : !(ear_area > 0)) return false;
    if (tolerance == kConvex) return true;
    budget_ -= static_cast<int64_t>(reflex_.size()) + 1;
    size_t kept = 0;
    bool blocked = false;
    for (size_t i = 0; i < reflex_.size(); ++i) {
      const uint32_t other = reflex_[i];
      if (removed_[other]) continue;
      reflex_[kept++] = other;
      if (other == before || other == corner || other == after) continue;
      blocked = blocked || holds(before, corner, after, other, tolerance);
    }
    reflex_.resize(kept);
    return !blocked;
  }

  bool holds(uint32_t a, uint32_t b, uint32_t c, uint32_t point, int tolerance) const {
    const glm::dvec2 p = points_[point];
    if (p == points_[a] || p == points_[b] || p == points_[c]) return false;
    const double least = std::min({cross(points_[a], points_[b], p), cross(points_[b], points_[c], p),
                                   cross(points_[c], points_[a], p)});
    return tolerance == kStrict ? least >= 0 : least > 0;
  }

  /// Tests of one corner against one ear; beyond that, any ear will do. A polygon that needs more is not
  /// simple or has tens of thousands of corners.
  static constexpr int64_t kLeastBudget = 100'000;
  static constexpr int64_t kBudgetPerCorner = 8192;

  uint32_t size_;
  std::vector<glm::dvec2> points_;
  std::vector<uint32_t> before_;
  std::vector<uint32_t> after_;
  std::vector<bool> removed_;
  std::vector<uint32_t> reflex_;  ///< corners that were not convex at first, less those cut off
  int64_t budget_ = 0;
};

/// Of the two diagonals, one that lies inside; of two such the shorter.
void cutQuad(std::span<const glm::dvec3> corners, std::vector<glm::u32vec3>& triangles) {
  // The quad's area vector; a triangle lies inside if its own points the same way.
  const glm::dvec3 normal = glm::cross(corners[2] - corners[0], corners[3] - corners[1]);
  const auto area = [&](int a, int b, int c) {
    return glm::dot(glm::cross(corners[b] - corners[a], corners[c] - corners[a]), normal);
  };
  const double first = std::min(area(0, 1, 2), area(0, 2, 3));
  const double second = std::min(area(1, 2, 3), area(1, 3, 0));
  const glm::dvec3 diagonal_02 = corners[2] - corners[0];
  const glm::dvec3 diagonal_13 = corners[3] - corners[1];
  const bool both_inside = first > 0 && second > 0;
  const bool use_13 =
      both_inside ? glm::dot(diagonal_13, diagonal_13) < glm::dot(diagonal_02, diagonal_02) : second > first;
  if (use_13) {
    triangles.insert(triangles.end(), {{0, 1, 3}, {1, 2, 3}});
  } else {
    triangles.insert(triangles.end(), {{0, 1, 2}, {0, 2, 3}});
  }
}

}  // namespace

void triangulate(std::span<const glm::dvec3> corners, std::vector<glm::u32vec3>& triangles) {
  triangles.clear();
  if (corners.size() == 3) {
    triangles.emplace_back(0, 1, 2);
  } else if (corners.size() == 4) {
    cutQuad(corners, triangles);
  } else if (corners.size() > 4) {
    Outline(corners).clip(triangles);
  }
}

}  // namespace lode::ingest
