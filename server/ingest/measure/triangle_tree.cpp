#include "server/ingest/measure/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/nearest_point.h"

namespace lode::ingest {
namespace {

constexpr size_t kMostHalvings = 32;  ///< enough for 32-bit triangle numbers
/// Largest number of entries on the search stack. A fork halves its triangles twice, and its four branches
/// replace its one entry.
constexpr size_t kMostWaiting = 3 * kMostHalvings / 2 + 1;

/// Estimates the number of forks in a tree, assuming that every fork divides its triangles into quarters.
size_t forksOver(size_t triangles) {
  size_t forks = 0;
  for (size_t level = 1; 4 * level < triangles; level *= 4) forks += level;
  return forks;
}

struct Triangle {
  glm::vec3 a;
  TriangleSides sides;
};

Triangle triangleOf(const NodeMesh& mesh, uint32_t number) {
  const auto corner = [&](int k) {
    return glm::vec3(unpackPosition(mesh.positions[mesh.wedge_position[mesh.triangles[number][k]]]));
  };
  const glm::vec3 a = corner(0);
  return {a, {corner(1) - a, corner(2) - a}};
}

TriangleCorners exactly(const PackedTriangle& triangle) {
  const auto vectorOf = [](Four four) { return glm::dvec3(four[0], four[1], four[2]); };
  const glm::dvec3 a = vectorOf(triangle.a());
  return {a, a + vectorOf(triangle.ab()), a + vectorOf(triangle.ac())};
}

/// Returns a limit for the squared distances of boxes, which have only single precision. A box above the
/// limit contains no point within `distance`.
float squaredReach(double distance) {
  constexpr double kRounding =
      1;  // more than the rounding errors of three coordinates below 2^21, in lattice steps
  return static_cast<float>((distance + kRounding) * (distance + kRounding));
}

}  // namespace

TriangleTree::TriangleTree(const NodeMesh& mesh) : place_(mesh.triangles.size()) {
  if (place_.empty()) return;
  std::vector<Middle> middles;
  middles.reserve(mesh.triangles.size());
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, sides] = triangleOf(mesh, t);
    middles.push_back({3.f * a + sides.ab + sides.ac, t});
  }
  const size_t places = (middles.size() + 3) / 4 * 4;
  triangles_.reserve(places);
  number_.reserve(places);
  forks_.reserve(forksOver(places));
  top_ = build(mesh, middles).inside;
}

TriangleTree::Branch TriangleTree::buildLeaf(const NodeMesh& mesh, std::span<const Middle> middles) {
  const auto begin = static_cast<uint32_t>(triangles_.size());
  Box box;
  for (const Middle& middle : middles) {
    const auto [a, sides] = triangleOf(mesh, middle.triangle);
    const glm::vec3 b = a + sides.ab, c = a + sides.ac;
    box.min = glm::min(box.min, glm::min(a, glm::min(b, c)));
    box.max = glm::max(box.max, glm::max(a, glm::max(b, c)));
    place_[middle.triangle] = static_cast<uint32_t>(triangles_.size());
    triangles_.emplace_back(a, sides);
    number_.push_back(middle.triangle);
  }
  triangles_.resize(begin + 4);
  number_.resize(begin + 4);
  return {begin | kIsLeaf, box};
}

/// Partitions triangles at their median along the longest side of the box around their centroids. @return the
/// size of the first half, a multiple of four, so that the half fills whole leaves.
size_t TriangleTree::partInHalves(std::span<Middle> middles) {
  glm::vec3 low(middles[0].at), high(low);
  for (const Middle& middle : middles) {
    low = glm::min(low, middle.at);
    high = glm::max(high, middle.at);
  }
  const glm::vec3 size = high - low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const size_t half = (middles.size() + 7) / 8 * 4;
  std::nth_element(middles.begin(), middles.begin() + static_cast<ptrdiff_t>(half), middles.end(),
                   [axis](const Middle& a, const Middle& b) {
                     return a.at[axis] != b.at[axis] ? a.at[axis] < b.at[axis] : a.triangle < b.triangle;
                   });
  return half;
}

/// Builds the subtree of some triangles. @param middles  their centroids times three; reordered.
TriangleTree::Branch TriangleTree::build(const NodeMesh& mesh, std::span<Middle> middles) {
  if (middles.size() <= 4) return buildLeaf(mesh, middles);
  std::array<std::span<Middle>, 4> parts;
  size_t count = 0;
  const size_t half = partInHalves(middles);
  for (const std::span<Middle> part : {middles.first(half), middles.subspan(half)}) {
    const size_t quarter = part.size() <= 4 ? part.size() : partInHalves(part);
    parts[count++] = part.first(quarter);
    if (quarter < part.size()) parts[count++] = part.subspan(quarter);
  }
  const auto number = static_cast<uint32_t>(forks_.size());
  forks_.emplace_back();
  std::array<Branch, 4> in{};
  Box whole;
  for (size_t i = 0; i < count; ++i) {
    in[i] = build(mesh, parts[i]);
    whole.min = glm::min(whole.min, in[i].box.min);
    whole.max = glm::max(whole.max, in[i].box.max);
  }
  forks_[number] = {{in[0].box.min, in[1].box.min, in[2].box.min, in[3].box.min},
                    {in[0].box.max, in[1].box.max, in[2].box.max, in[3].box.max},
                    {in[0].inside, in[1].inside, in[2].inside, in[3].inside}};
  return {number, whole};
}

Four TriangleTree::Fork::squaredDistances(const FourVectors& points) const noexcept {
  const Four zero{};
  const FourVectors below = min - points, above = points - max;
  const FourVectors outside{larger(larger(below.x, above.x), zero), larger(larger(below.y, above.y), zero),
                            larger(larger(below.z, above.z), zero)};
  return dot(outside, outside);
}

/// Visits the leaves that have boxes nearer than reach(), near ones first.
/// @param reach  returns a squared distance, which may fall with each visit; 0 ends the search.
/// @param visit  receives the index of the leaf's first triangle in triangles_.
template <typename Reach, typename Visit>
void TriangleTree::search(const FourVectors& points, const Reach& reach, const Visit& visit) const noexcept {
  if (triangles_.empty()) return;
  struct Waiting {
    uint32_t inside;
    float squared;
  };
  // Stack of forks and leaves. The entries of one fork are in descending order of distance, so that the
  // nearest is taken first.
  std::array<Waiting, kMostWaiting> waiting;
  size_t count = 0;
  waiting[count++] = {top_, 0};
  while (count > 0) {
    const auto [inside, squared] = waiting[--count];
    if (squared >= reach()) continue;
    if (inside & kIsLeaf) {
      visit(inside & ~kIsLeaf);
      continue;
    }
    const Fork& fork = forks_[inside];
    const Four away = fork.squaredDistances(points);
    const size_t first = count;
    for (size_t i = 4; i-- > 0;) {
      if (!(away[i] < reach())) continue;
      size_t at = count++;
      for (; at > first && waiting[at - 1].squared < away[i]; --at) waiting[at] = waiting[at - 1];
      waiting[at] = {fork.inside[i], away[i]};
    }
  }
}

TriangleTree::Nearest TriangleTree::nearestWithin(glm::vec3 point, float tolerance, Nearest bound,
                                                  uint64_t& leaves) const noexcept {
  if (triangles_.empty()) return bound;
  const FourVectors points(point, point, point, point);
  const float tolerance_squared = tolerance * tolerance;
  const auto reach = [&] { return bound.squared > tolerance_squared && leaves > 0 ? bound.squared : 0; };
  search(points, reach, [&](size_t begin) {
    --leaves;
    const PackedTriangle* const leaf = &triangles_[begin];
    const Four found = FourTriangles(leaf[0], leaf[1], leaf[2], leaf[3]).squaredDistances(points);
    for (size_t i = 0; i < 4; ++i)
      if (found[i] < bound.squared) bound = {found[i], 0, number_[begin + i]};
  });
  bound.distance = std::sqrt(bound.squared);
  return bound;
}

TriangleTree::ExactNearest TriangleTree::nearestExactly(glm::dvec3 point, double tolerance,
                                                        ExactNearest bound) const noexcept {
  const auto reach = [&] { return bound.distance > tolerance ? squaredReach(bound.distance) : 0; };
  search(FourVectors(glm::vec3(point)), reach, [&](size_t begin) {
    for (size_t i = begin; i < begin + 4; ++i) {
      const double distance = glm::distance(point, nearestPointOfTriangle(point, exactly(triangles_[i])));
      if (distance < bound.distance) bound = {distance, number_[i]};  // false for an empty triangle
    }
  });
  return bound;
}

}  // namespace lode::ingest
