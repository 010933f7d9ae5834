#include "server/ingest/soup/lost_triangles.h"

#include <algorithm>
#include <cstdio>

#include "common/printable.h"
#include "server/ingest/soup/triangulate.h"

namespace lode::ingest {
namespace {

/// Largest acceptable fraction of lost triangles. If more are lost, the model's box is too large for its
/// details.
constexpr double kMostLostShare = 0.5;

std::string inDigits(double value, int digits = 6) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

std::string inDigits(glm::dvec3 v) {
  return "[" + inDigits(v.x) + ", " + inDigits(v.y) + ", " + inDigits(v.z) + "]";
}

}  // namespace

bool LostTriangles::areMost() const noexcept {
  return static_cast<double>(lost) > kMostLostShare * static_cast<double>(of);
}

std::string LostTriangles::inWords() const {
  if (areMost())
    return std::to_string(lost) + " of " + counted(of, "triangle") +
           " would be lost: their corners are closer than a 2-millionth of the model, which extends from " +
           inDigits(min) + " to " + inDigits(max) + "; remove distant stray vertices, or split the model";
  return "a build drops " + counted(lost, "triangle") + " with corners less than " + inDigits(step, 3) +
         " apart, the finest lattice step for a model of this size; split the model to keep them, or merge "
         "such corners to avoid gaps";
}

uint64_t LostTriangleCounter::count(std::span<const glm::dvec3> corners) {
  snapped_.clear();
  for (const glm::dvec3 corner : corners) snapped_.push_back(packPosition(lattice_.snap(corner)));
  if (corners.size() == 3) return isLost(corners, {0, 1, 2});
  if (!someMeet()) return 0;
  outline_.clear();
  for (const PositionCode code : snapped_) outline_.emplace_back(unpackPosition(code));
  triangulate(outline_, cut_);
  return static_cast<uint64_t>(
      std::ranges::count_if(cut_, [&](glm::u32vec3 triangle) { return isLost(corners, triangle); }));
}

bool LostTriangleCounter::isLost(std::span<const glm::dvec3> corners, glm::u32vec3 t) const {
  const bool meet =
      snapped_[t.x] == snapped_[t.y] || snapped_[t.y] == snapped_[t.z] || snapped_[t.z] == snapped_[t.x];
  return meet && corners[t.x] != corners[t.y] && corners[t.y] != corners[t.z] && corners[t.z] != corners[t.x];
}

bool LostTriangleCounter::someMeet() {
  sorted_ = snapped_;
  std::ranges::sort(sorted_);
  return std::ranges::adjacent_find(sorted_) != sorted_.end();
}

}  // namespace lode::ingest
