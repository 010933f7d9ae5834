#include "server/ingest/simplify/collapse_check.h"

#include <algorithm>

#include "server/ingest/mesh/four_vectors.h"

namespace lode::ingest {

namespace {

/// Two doubles for SIMD; see Four.
using Two = double __attribute__((vector_size(16)));
/// Result of comparing two pairs of doubles.
using TwoTruths = int64_t __attribute__((vector_size(16)));

inline Two twoOf(double value) noexcept { return Two{value, value}; }
inline Two larger(Two a, Two b) noexcept { return a > b ? a : b; }
inline bool anyOf(TwoTruths truths) noexcept { return (truths[0] | truths[1]) != 0; }

struct TwoVectors {
  TwoVectors(Two of_x, Two of_y, Two of_z) noexcept : x(of_x), y(of_y), z(of_z) {}
  TwoVectors(glm::dvec3 a, glm::dvec3 b) noexcept : x{a.x, b.x}, y{a.y, b.y}, z{a.z, b.z} {}
  /// Converts the first two or the last two of four vectors to doubles.
  TwoVectors(const FourVectors& four, bool last) noexcept
      : x(half(four.x, last)), y(half(four.y, last)), z(half(four.z, last)) {}

  Two x, y, z;

 private:
  static Two half(Four four, bool last) noexcept {
    using Half = float __attribute__((vector_size(8)));
    return last ? __builtin_convertvector(__builtin_shufflevector(four, four, 2, 3), Two)
                : __builtin_convertvector((Half{four[0], four[1]}), Two);
  }
};

inline TwoVectors operator-(const TwoVectors& a, const TwoVectors& b) noexcept {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Two dot(const TwoVectors& a, const TwoVectors& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline TwoVectors cross(const TwoVectors& a, const TwoVectors& b) noexcept {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}

/// Returns true if one of two triangles (a, b, from) turns too far or becomes too thin when its corner `from`
/// moves to `to`.
bool harms(const TwoVectors& a, const TwoVectors& b, const TwoVectors& from, const TwoVectors& to,
           const CollapseLimits& limits) {
  const TwoVectors side = b - a, old_side = from - a, new_side = to - a;
  const TwoVectors old_normal = cross(side, old_side), new_normal = cross(side, new_side);
  const Two old_square = dot(old_normal, old_normal), new_square = dot(new_normal, new_normal);
  const Two cosine = dot(old_normal, new_normal), square = cosine * cosine;
  const Two bound = limits.least_cosine * limits.least_cosine * old_square * new_square;
  const TwoTruths turns =
      limits.least_cosine >= 0 ? (cosine <= 0) | (square < bound) : (cosine < 0) & (square > bound);
  const auto longest = [&](const TwoVectors& other_side, const TwoVectors& end) {
    const TwoVectors last_side = b - end;
    return larger(larger(dot(side, side), dot(other_side, other_side)), dot(last_side, last_side));
  };
  const Two new_longest = longest(new_side, to);
  const TwoTruths thin = new_square < limits.least_shape * limits.least_shape * new_longest * new_longest;
  if (!anyOf(turns | thin)) return false;
  const Two old_longest = longest(old_side, from);
  const TwoTruths thinner = new_square * old_longest * old_longest < old_square * new_longest * new_longest;
  return anyOf((turns | (thin & thinner)) & (old_square != 0));
}

}  // namespace

bool CollapseCheck::keepsShapes(const EdgeSurroundings& around, glm::dvec3 to,
                                const CollapseLimits& limits) const {
  const glm::dvec3 at_u = mesh_.point(around.u()), at_v = mesh_.point(around.v());
  const size_t of_u = around.ofU().size(), all = of_u + around.ofV().size();
  const TwoVectors target(to, to);
  for (size_t i = 0; i < all; i += 2) {
    const size_t next = std::min(i + 1, all - 1);
    const TwoVectors from(i < of_u ? at_u : at_v, next < of_u ? at_u : at_v);
    const EdgeSurroundings::FourSides& sides = around.places()[i / 4];
    const bool last = i % 4 != 0;
    if (harms({sides.a, last}, {sides.b, last}, from, target, limits)) return false;
  }
  return true;
}

double CollapseCheck::areaOf(uint32_t u, uint32_t a, uint32_t b) const {
  return glm::length(glm::cross(mesh_.point(a) - mesh_.point(u), mesh_.point(b) - mesh_.point(u)));
}

bool CollapseCheck::hasSide(std::span<const EdgeSurroundings::Side> sides, EdgeSurroundings::Side side) {
  const auto endsOf = [](const EdgeSurroundings::Side& of) {
    return uint64_t{std::min(of.a, of.b)} << 32 | std::max(of.a, of.b);
  };
  if (sides.size() <= kFewSides)
    return std::ranges::any_of(sides, [&](const auto& of_u) { return endsOf(of_u) == endsOf(side); });
  if (ends_of_u_.empty()) {
    for (const EdgeSurroundings::Side& of_u : sides) ends_of_u_.push_back(endsOf(of_u));
    std::sort(ends_of_u_.begin(), ends_of_u_.end());
  }
  return std::binary_search(ends_of_u_.begin(), ends_of_u_.end(), endsOf(side));
}

CollapseFinding CollapseCheck::check(const EdgeSurroundings& around, glm::dvec3 to,
                                     const CollapseLimits& limits) {
  CollapseFinding finding;
  if (!keepsShapes(around, to, limits)) return finding;
  stamp_ += kMarks;
  for (const EdgeSurroundings::Side& side : around.ofU()) marks_[side.a] = marks_[side.b] = stamp_;
  for (const uint32_t apex : around.apexes()) marks_[apex] = stamp_ + kApex;
  bool others_meet = false;
  ends_of_u_.clear();
  for (const EdgeSurroundings::Side& side : around.ofV()) {
    const uint32_t mark_a = marks_[side.a], mark_b = marks_[side.b];
    others_meet |= (mark_a == stamp_) | (mark_b == stamp_);
    if ((mark_a < stamp_) | (mark_b < stamp_)) continue;
    if (!hasSide(around.ofU(), side)) continue;
    finding.folds = true;
    finding.folded_area += areaOf(around.u(), side.a, side.b);
  }
  finding.allowed = !limits.link_condition || !others_meet;
  return finding;
}

}  // namespace lode::ingest
