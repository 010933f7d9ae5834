#include "tests/support/surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace lode::test {

namespace {

constexpr uint32_t kTrianglesPerLeaf = 4;

double squaredDistanceToBox(glm::dvec3 p, glm::dvec3 min, glm::dvec3 max) {
  const glm::dvec3 d = glm::max(glm::max(min - p, p - max), glm::dvec3(0));
  return glm::dot(d, d);
}

}  // namespace

/// A node of the tree. An inner node has the count 0 and the children `first` and `first + 1`. A leaf has the
/// triangles first..first+count.
struct DistanceField::Node {
  glm::dvec3 min, max;
  uint32_t first = 0, count = 0;
};

DistanceField::DistanceField(std::span<const Triangle3> soup) : triangles_(soup.begin(), soup.end()) {
  if (triangles_.empty()) return;
  nodes_.reserve(triangles_.size());
  nodes_.emplace_back();
  build(0, 0, static_cast<uint32_t>(triangles_.size()));
}

DistanceField::~DistanceField() = default;
DistanceField::DistanceField(DistanceField&&) noexcept = default;
DistanceField& DistanceField::operator=(DistanceField&&) noexcept = default;

void DistanceField::build(uint32_t node, uint32_t begin, uint32_t end) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  glm::dvec3 min(kInfinity), max(-kInfinity), centre_min(kInfinity), centre_max(-kInfinity);
  for (uint32_t i = begin; i < end; ++i) {
    const Triangle3& t = triangles_[i];
    min = glm::min(min, glm::min(t.a, glm::min(t.b, t.c)));
    max = glm::max(max, glm::max(t.a, glm::max(t.b, t.c)));
    const glm::dvec3 centre = t.a + t.b + t.c;
    centre_min = glm::min(centre_min, centre);
    centre_max = glm::max(centre_max, centre);
  }
  nodes_[node] = {min, max, begin, end - begin};
  if (end - begin <= kTrianglesPerLeaf) return;
  const glm::dvec3 extent = centre_max - centre_min;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(triangles_.begin() + begin, triangles_.begin() + middle, triangles_.begin() + end,
                   [axis](const Triangle3& s, const Triangle3& t) {
                     return s.a[axis] + s.b[axis] + s.c[axis] < t.a[axis] + t.b[axis] + t.c[axis];
                   });
  const uint32_t children = static_cast<uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[node].first = children;
  nodes_[node].count = 0;
  build(children, begin, middle);
  build(children + 1, middle, end);
}

/// Source: Ericson, Real-Time Collision Detection, 2005, 5.1.5.
double DistanceField::squaredDistanceTo(glm::dvec3 p, uint32_t triangle) const {
  const auto& [a, b, c] = triangles_[triangle];
  const auto to = [p](glm::dvec3 q) { return glm::dot(p - q, p - q); };
  const glm::dvec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return to(a);
  const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return to(b);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return d1 == d3 ? to(a) : to(a + d1 / (d1 - d3) * ab);
  const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return to(c);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return d2 == d6 ? to(a) : to(a + d2 / (d2 - d6) * ac);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double length = (d4 - d3) + (d5 - d6);
    return length == 0 ? to(b) : to(b + (d4 - d3) / length * (c - b));
  }
  const double sum = va + vb + vc;
  return sum == 0 ? std::min({to(a), to(b), to(c)}) : to(a + ab * (vb / sum) + ac * (vc / sum));
}

double DistanceField::distance(glm::dvec3 point, uint32_t& hint) const {
  if (nodes_.empty()) return std::numeric_limits<double>::infinity();
  if (hint >= triangles_.size()) hint = 0;
  double best = squaredDistanceTo(point, hint);
  std::array<std::pair<uint32_t, double>, 128> stack;
  size_t depth = 0;
  stack[depth++] = {0, squaredDistanceToBox(point, nodes_[0].min, nodes_[0].max)};
  while (depth > 0) {
    const auto [number, bound] = stack[--depth];
    if (bound >= best) continue;
    const Node& node = nodes_[number];
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      const double d = squaredDistanceTo(point, i);
      if (d < best) {
        best = d;
        hint = i;
      }
    }
    if (node.count != 0) continue;
    std::pair near{node.first, squaredDistanceToBox(point, nodes_[node.first].min, nodes_[node.first].max)};
    std::pair far{node.first + 1,
                  squaredDistanceToBox(point, nodes_[node.first + 1].min, nodes_[node.first + 1].max)};
    if (far.second < near.second) std::swap(near, far);
    if (far.second < best) stack[depth++] = far;
    if (near.second < best) stack[depth++] = near;
  }
  return std::sqrt(best);
}

std::vector<glm::dvec3> samplePoints(std::span<const Triangle3> soup, size_t count, uint64_t seed) {
  const auto area = [](const Triangle3& t) { return glm::length(glm::cross(t.b - t.a, t.c - t.a)); };
  double total = 0;
  for (const Triangle3& t : soup) total += area(t);
  std::vector<glm::dvec3> points;
  if (!(total > 0)) return points;
  points.reserve(count + 1);
  std::mt19937_64 random(seed);
  const auto unit = [&random] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const double stride = total / static_cast<double>(count);
  double next = stride * unit(), passed = 0;
  for (const Triangle3& t : soup) {
    passed += area(t);
    for (; next < passed; next += stride) {
      const double root = std::sqrt(unit()), v = unit();
      points.push_back(t.a * (1 - root) + t.b * (root * (1 - v)) + t.c * (root * v));
    }
  }
  return points;
}

namespace {

SampledDistance oneWay(std::span<const Triangle3> from, const DistanceField& to, size_t samples,
                       uint64_t seed) {
  SampledDistance result;
  uint32_t hint = 0;
  const std::vector<glm::dvec3> points = samplePoints(from, samples, seed);
  for (const glm::dvec3 p : points) {
    const double d = to.distance(p, hint);
    result.rms += d * d;
    result.max = std::max(result.max, d);
  }
  if (!points.empty()) result.rms = std::sqrt(result.rms / static_cast<double>(points.size()));
  return result;
}

}  // namespace

SurfaceDistance surfaceDistance(std::span<const Triangle3> first, std::span<const Triangle3> second,
                                size_t samples, uint64_t seed) {
  SurfaceDistance result;
  result.forward = oneWay(first, DistanceField(second), samples, seed);
  result.backward = oneWay(second, DistanceField(first), samples, seed + 1);
  const double f = result.forward.rms, b = result.backward.rms;
  result.both = {std::sqrt((f * f + b * b) / 2), std::max(result.forward.max, result.backward.max)};
  return result;
}

double boxDiagonal(std::span<const Triangle3> soup) {
  if (soup.empty()) return 0;
  glm::dvec3 min = soup[0].a, max = min;
  for (const Triangle3& t : soup) {
    min = glm::min(min, glm::min(t.a, glm::min(t.b, t.c)));
    max = glm::max(max, glm::max(t.a, glm::max(t.b, t.c)));
  }
  return glm::distance(min, max);
}

TriangleSoup latticeSoup(const Mesh& mesh) {
  const auto corner = [&mesh](uint32_t v) { return glm::dvec3(unpackPosition(mesh.positions[v])); };
  TriangleSoup soup;
  soup.reserve(mesh.triangles.size());
  for (const glm::u32vec3 t : mesh.triangles) soup.push_back({corner(t.x), corner(t.y), corner(t.z)});
  return soup;
}

}  // namespace lode::test
