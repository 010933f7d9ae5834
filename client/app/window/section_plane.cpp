#include "client/app/window/section_plane.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lode::app {
namespace {

/// Least length of an axis's projection at which a drag moves the plane along the axis.
constexpr double kLeastAcross = 0.25;

}  // namespace

void SectionPlane::step(const core::ModelBox& box) noexcept {
  axis_ = (axis_ + 1) % 4;
  if (isOn()) place_model_ = glm::mix(box.min[axis_], box.max[axis_], 0.5);
  is_flipped_ = false;
}

void SectionPlane::drag(const glm::dvec2& pixels, const core::View& view, double distance_model,
                        const core::ModelBox& box) noexcept {
  if (!isOn() || pixels == glm::dvec2(0)) return;
  const glm::dvec3 right = glm::cross(view.forward, view.up);
  const glm::dvec2 across(right[axis_], -view.up[axis_]);
  const double length = glm::length(across);
  const double moved_px = length > kLeastAcross ? glm::dot(pixels, across) / (length * length)
                                                : -pixels.y * (view.forward[axis_] < 0 ? -1 : 1);
  const double moved_model = moved_px * distance_model / core::focalPx(view);
  place_model_ = std::clamp(place_model_ + moved_model, box.min[axis_], box.max[axis_]);
}

std::optional<render::Section> SectionPlane::section() const noexcept {
  if (!isOn()) return std::nullopt;
  render::Section section;
  section.normal = glm::dvec3(0);
  section.normal[axis_] = is_flipped_ ? -1 : 1;
  section.offset_model = place_model_ * section.normal[axis_];
  section.cap_srgb = kCapColours[colour_].srgb;
  return section;
}

std::string SectionPlane::describe(const core::ModelBox& box) const {
  if (!isOn()) return "no section";
  const double size_model = box.max[axis_] - box.min[axis_];
  const double part = size_model > 0 ? (place_model_ - box.min[axis_]) / size_model : 0.5;
  return "section across " + std::string(1, static_cast<char>('x' + axis_)) + " at " +
         std::to_string(std::lround(part * 100)) + " %";
}

std::optional<ShownRay> shownRay(const glm::dvec3& origin_model, const glm::dvec3& direction,
                                 const render::Section& section) noexcept {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  const double beyond = glm::dot(section.normal, origin_model) - section.offset_model;
  const double slope = glm::dot(section.normal, direction);
  if (beyond > 0) {
    if (slope >= 0) return std::nullopt;
    return ShownRay{origin_model + direction * (beyond / -slope), kEndless, true};
  }
  return ShownRay{origin_model, slope > 0 ? -beyond / slope : kEndless};
}

}  // namespace lode::app
