#include "tests/bench/attribute_loss.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/codec/octahedral.h"

namespace lode::bench {
namespace {

constexpr double kOtherChart = 65536.0 / 16;  // a texture coordinate further off is not the same chart's

std::array<double, 9> numbersOf(const test::Triangle3& t) {
  return {t.a.x, t.a.y, t.a.z, t.b.x, t.b.y, t.b.z, t.c.x, t.c.y, t.c.z};
}

/// Weights of the corners at the point of the triangle's plane nearest to p, moved into the triangle.
glm::dvec3 sharesAt(const test::Triangle3& t, glm::dvec3 p) {
  const glm::dvec3 u = t.b - t.a, v = t.c - t.a, w = p - t.a, n = glm::cross(u, v);
  const double square = glm::dot(n, n);
  if (square == 0) return {1, 0, 0};
  const double b = glm::dot(glm::cross(w, v), n) / square, c = glm::dot(glm::cross(u, w), n) / square;
  const glm::dvec3 inside = glm::max(glm::dvec3(1 - b - c, b, c), 0.0);
  return inside / (inside.x + inside.y + inside.z);
}

double meanOf(glm::dvec3 v) { return (std::abs(v.x) + std::abs(v.y) + std::abs(v.z)) / 3; }

struct Sums {
  double colour = 0, normal = 0, texture = 0, squares = 0;
  size_t samples = 0, in_chart = 0;
};

void addWay(const AttributeField& from, const AttributeField& to, size_t samples, uint64_t seed, Sums& sums) {
  uint32_t own = 0, other = 0;
  for (const glm::dvec3 p : test::samplePoints(from.soup(), samples, seed)) {
    double none = 0, distance = 0;
    const AttributeField::Value a = from.at(p, own, none), b = to.at(p, other, distance);
    sums.squares += distance * distance;
    ++sums.samples;
    sums.colour += meanOf(a.colour - b.colour);
    sums.normal += std::acos(std::clamp(glm::dot(a.normal, b.normal), -1.0, 1.0));
    const glm::dvec2 moved = glm::abs(a.texture - b.texture);
    if (a.material != b.material || std::max(moved.x, moved.y) > kOtherChart) continue;
    ++sums.in_chart;
    sums.texture += (moved.x + moved.y) / 2;
  }
}

}  // namespace

bool AttributeField::Less::operator()(const test::Triangle3& s, const test::Triangle3& t) const {
  return numbersOf(s) < numbersOf(t);
}

AttributeField::AttributeField(const ingest::NodeMesh& mesh)
    : mesh_(mesh), soup_(latticeSoup(mesh)), field_(soup_) {
  for (uint32_t i = 0; i < soup_.size(); ++i) number_[soup_[i]] = i;
}

AttributeField::Value AttributeField::at(glm::dvec3 point, uint32_t& hint, double& distance) const {
  distance = field_.distance(point, hint);
  const test::Triangle3& nearest = field_.triangle(hint);
  return mix(number_.at(nearest), sharesAt(nearest, point));
}

AttributeField::Value AttributeField::mix(uint32_t triangle, glm::dvec3 share) const {
  Value value;
  for (int k = 0; k < 3; ++k) {
    const VertexAttributes& attributes = mesh_.wedge_attributes[mesh_.triangles[triangle][k]];
    value.colour += share[k] * glm::dvec3(attributes.colour);
    value.normal += share[k] * glm::dvec3(decodeOctahedral(attributes.normal));
    value.texture += share[k] * glm::dvec2(attributes.texture);
    value.material = attributes.material;
  }
  const double length = glm::length(value.normal);
  value.normal = length > 0 ? value.normal / length : glm::dvec3(0, 0, 1);
  return value;
}

AttributeLoss attributeLoss(const AttributeField& original, const ingest::NodeMesh& simple, size_t samples) {
  const AttributeField other(simple);
  Sums sums;
  addWay(original, other, samples, 1, sums);
  addWay(other, original, samples, 2, sums);
  const auto count = static_cast<double>(sums.samples), in_chart = static_cast<double>(sums.in_chart);
  return {.colour = sums.colour / count,
          .normal_deg = sums.normal / count * 180 / std::numbers::pi,
          .texture = sums.texture / std::max(in_chart, 1.0),
          .other_charts = 1 - in_chart / count,
          .surface = std::sqrt(sums.squares / count) / test::boxDiagonal(original.soup())};
}

}  // namespace lode::bench
