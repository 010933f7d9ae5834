#include "server/ingest/soup/triangulate.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

namespace lode::ingest {
namespace {

/// Returns twice the signed area of a triangle.
double cross(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Rules for accepting a corner as an ear, from strict to lax. No simple polygon needs a rule beyond kFlat.
enum Tolerance { kStrict, kTouching, kFlat, kConvex, kAny };

/// A grid of square cells with about one point per cell, which finds the points near a triangle.
class PointGrid {
 public:
  PointGrid() = default;
  PointGrid(const std::vector<glm::dvec2>& points, const std::vector<uint32_t>& numbers) {
    if (numbers.empty()) return;
    glm::dvec2 high = low_ = points[numbers.front()];
    for (const uint32_t i : numbers) {
      low_ = glm::min(low_, points[i]);
      high = glm::max(high, points[i]);
    }
    cells_ = numbers.size() < 16 ? 1 : static_cast<uint32_t>(std::sqrt(static_cast<double>(numbers.size())));
    const double extent = std::max({high.x - low_.x, high.y - low_.y, 1e-300});
    scale_ = static_cast<double>(cells_) / extent;
    starts_.assign(size_t{cells_} * cells_ + 1, 0);
    for (const uint32_t i : numbers) ++starts_[cellOf(points[i]) + 1];
    for (size_t cell = 1; cell < starts_.size(); ++cell) starts_[cell] += starts_[cell - 1];
    numbers_.resize(numbers.size());
    std::vector<uint32_t> next(starts_.begin(), starts_.end() - 1);
    for (const uint32_t i : numbers) numbers_[next[cellOf(points[i])]++] = i;
  }

  /// Returns true if `test` accepts any point in the cells that a triangle's box touches. Subtracts the
  /// number of visited cells and points from the budget.
  template <class Test>
  bool any(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c, int64_t& budget, const Test& test) const {
    if (cells_ == 0) return false;
    const glm::dvec2 low = glm::min(a, glm::min(b, c));
    const glm::dvec2 high = glm::max(a, glm::max(b, c));
    const uint32_t last_x = place(high.x - low_.x);
    const uint32_t last_y = place(high.y - low_.y);
    for (uint32_t y = place(low.y - low_.y); y <= last_y; ++y) {
      for (uint32_t x = place(low.x - low_.x); x <= last_x; ++x) {
        const size_t cell = size_t{y} * cells_ + x;
        budget -= 1 + starts_[cell + 1] - starts_[cell];
        for (uint32_t i = starts_[cell]; i < starts_[cell + 1]; ++i) {
          if (test(numbers_[i])) return true;
        }
      }
    }
    return false;
  }

 private:
  uint32_t place(double along) const {
    return static_cast<uint32_t>(std::clamp(along * scale_, 0.0, static_cast<double>(cells_ - 1)));
  }
  size_t cellOf(glm::dvec2 point) const {
    return size_t{place(point.y - low_.y)} * cells_ + place(point.x - low_.x);
  }

  glm::dvec2 low_{0};
  double scale_ = 0;
  uint32_t cells_ = 0;  ///< number of cells per side
  std::vector<uint32_t> starts_;
  std::vector<uint32_t> numbers_;
};

/// A polygon projected onto the coordinate plane in which its area is largest. The projection is
/// counter-clockwise and scaled to a size of about 1.
class Outline {
 public:
  explicit Outline(std::span<const glm::dvec3> corners) : size_(static_cast<uint32_t>(corners.size())) {
    points_.resize(size_);
    double extent = 0;
    for (const glm::dvec3& corner : corners) {
      const glm::dvec3 relative = corner - corners[0];
      extent = std::max({extent, std::fabs(relative.x), std::fabs(relative.y), std::fabs(relative.z)});
    }
    if (!(extent > 0) || !std::isfinite(extent))
      return;              // leave all points at 0, so that every corner counts as an ear
    glm::dvec3 normal(0);  // sum of the area vectors, by Newell's method
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
    prepare();
    int tolerance = kStrict;
    for (uint32_t left = size_; left > 3;) {
      if (candidates_.empty()) {
        ++tolerance;
        queueAll();
      }
      const uint32_t corner = candidates_.front();
      candidates_.pop_front();
      if (removed_[corner] || !isEar(corner, budget_ > 0 ? tolerance : kAny)) continue;
      const uint32_t before = before_[corner];
      const uint32_t after = after_[corner];
      triangles.emplace_back(before, corner, after);
      after_[before] = after;
      before_[after] = before;
      removed_[corner] = true;
      --left;
      if (tolerance != kStrict) candidates_.clear();
      tolerance = kStrict;
      candidates_.push_back(before);  // only the two neighbours can become ears
      candidates_.push_back(after);
    }
    const uint32_t last =
        static_cast<uint32_t>(std::find(removed_.begin(), removed_.end(), false) - removed_.begin());
    triangles.emplace_back(before_[last], last, after_[last]);
  }

 private:
  void prepare() {
    before_.resize(size_);
    after_.resize(size_);
    removed_.assign(size_, false);
    std::vector<uint32_t> reflex;
    for (uint32_t i = 0; i < size_; ++i) {
      before_[i] = i == 0 ? size_ - 1 : i - 1;
      after_[i] = i + 1 == size_ ? 0 : i + 1;
      if (!(area(before_[i], i, after_[i]) > 0)) reflex.push_back(i);
    }
    reflex_ = PointGrid(points_, reflex);
    budget_ = kLeastBudget + int64_t{size_} * kBudgetPerCorner;
    queueAll();
  }

  /// Queues every second corner first, because consecutive ears would form fans.
  void queueAll() {
    for (const uint32_t first : {0u, 1u}) {
      for (uint32_t i = first; i < size_; i += 2) {
        if (!removed_[i]) candidates_.push_back(i);
      }
    }
  }

  bool isEar(uint32_t corner, int tolerance) {
    if (tolerance == kAny) return true;
    --budget_;
    const uint32_t before = before_[corner];
    const uint32_t after = after_[corner];
    const double ear_area = area(before, corner, after);
    if (tolerance >= kFlat ? !(ear_area >= 0) : !(ear_area > 0)) return false;
    if (tolerance == kConvex) return true;
    return !reflex_.any(points_[before], points_[corner], points_[after], budget_, [&](uint32_t other) {
      return !removed_[other] && other != before && other != corner && other != after &&
             holds(before, corner, after, other, tolerance);
    });
  }

  bool holds(uint32_t a, uint32_t b, uint32_t c, uint32_t point, int tolerance) const {
    const glm::dvec2 p = points_[point];
    if (p == points_[a] || p == points_[b] || p == points_[c]) return false;
    const double least = std::min({cross(points_[a], points_[b], p), cross(points_[b], points_[c], p),
                                   cross(points_[c], points_[a], p)});
    return tolerance == kStrict ? least >= 0 : least > 0;
  }

  /// The number of tests of a corner against an ear is limited to kLeastBudget, plus kBudgetPerCorner per
  /// corner. Beyond this limit, clip() cuts off corners without tests.
  static constexpr int64_t kLeastBudget = 100'000;
  static constexpr int64_t kBudgetPerCorner = 1024;

  uint32_t size_;
  std::vector<glm::dvec2> points_;
  std::vector<uint32_t> before_;
  std::vector<uint32_t> after_;
  std::vector<bool> removed_;
  std::deque<uint32_t> candidates_;
  PointGrid reflex_;  ///< corners that are reflex in the uncut polygon; other corners cannot lie in an ear
  int64_t budget_ = 0;
};

/// Cuts a quad along a diagonal inside the quad. Chooses the shorter diagonal if both are inside.
void cutQuad(std::span<const glm::dvec3> corners, std::vector<glm::u32vec3>& triangles) {
  // Area vector of the quad. A triangle lies inside the quad if its area vector points in the same direction.
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
