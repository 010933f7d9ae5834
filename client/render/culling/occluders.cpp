#include "client/render/culling/occluders.h"

#include <algorithm>
#include <limits>

namespace lode::render {
namespace {

constexpr double kSlackPx = 1;        ///< rasterization exceeds the exact box by at most this distance
constexpr double kDepthSlack = 1e-4;  ///< relative error of a drawn depth

}  // namespace

Occluders::Occluders(const core::View& view, double step, const FarthestDepths& drawn)
    : drawn_(drawn),
      eye_(view.eye_model),
      forward_(view.forward),
      right_(glm::normalize(glm::cross(view.forward, view.up)) *
             (double{reversedProjection(view, step).scale.x} * view.width_px / 2)),
      up_(glm::normalize(glm::cross(right_, view.forward)) *
          (double{reversedProjection(view, step).scale.y} * view.height_px / 2)),
      size_px_(view.width_px, view.height_px),
      near_model_(reversedProjection(view, step).near_model) {}

bool Occluders::hide(const core::ModelBox& box) const noexcept {
  if (drawn_.depths.empty()) return false;
  const glm::dvec3 middle = (box.min + box.max) / 2.0 - eye_, half = (box.max - box.min) / 2.0;
  const double nearest = glm::dot(middle, forward_) - glm::dot(half, glm::abs(forward_));
  const double depth =
      near_model_ / std::max(nearest, std::numeric_limits<double>::min()) * (1 + kDepthSlack);
  if (depth >= 1) return false;  // the near plane may clip the box, so the box counts as visible
  glm::dvec2 least(std::numeric_limits<double>::infinity()), most = -least;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const glm::dvec3 side((corner & 1) * 2 - 1.0, (corner >> 1 & 1) * 2 - 1.0, (corner >> 2) * 2 - 1.0);
    const glm::dvec3 arm = middle + half * side;
    const glm::dvec2 place = glm::dvec2(glm::dot(arm, right_), glm::dot(arm, up_)) / glm::dot(arm, forward_);
    least = glm::min(least, place);
    most = glm::max(most, place);
  }
  constexpr double kSquare = FarthestDepths::kSquarePx;
  const glm::dvec2 limit(drawn_.columns - 1, drawn_.rows - 1);
  const glm::dvec2 first =
      glm::clamp(glm::floor((least + size_px_ / 2.0 - kSlackPx) / kSquare), {0, 0}, limit);
  const glm::dvec2 last = glm::clamp(glm::floor((most + size_px_ / 2.0 + kSlackPx) / kSquare), {0, 0}, limit);
  for (auto row = static_cast<size_t>(first.y); row <= static_cast<size_t>(last.y); ++row) {
    for (auto column = static_cast<size_t>(first.x); column <= static_cast<size_t>(last.x); ++column)
      if (drawn_.depths[row * drawn_.columns + column] <= depth) return false;
  }
  return true;
}

}  // namespace lode::render
