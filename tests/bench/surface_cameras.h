#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include <glm/glm.hpp>

#include "client/core/view/view.h"
#include "server/store/reader.h"

namespace lode::bench {

/// Random views of a surface: above a point of the surface, looking down at an angle.
class SurfaceCameras {
 public:
  SurfaceCameras(const store::Reader& store, uint32_t width_px, uint32_t height_px)
      : step_(store.summary().lattice.step), width_px_(width_px), height_px_(height_px) {
    for (const Node& node : store.nodes())
      if (node.isLeaf()) leaves_.push_back(core::toModelBox(node.box, step_));
    box_ = core::toModelBox(store.find(kRootKey)->box, step_);
    const glm::dvec3 size = box_.max - box_.min;
    for (int axis = 0; axis < 3; ++axis)
      if (size[axis] * 3 < std::max({size.x, size.y, size.z})) flat_axis_ = axis;
  }

  /// @param diagonals  distance from the surface, in diagonals of the model's box.
  core::View next(double diagonals) {
    glm::dvec3 out = glm::normalize(glm::dvec3(number(), number(), number()));
    if (flat_axis_ >= 0) out = glm::normalize(out * 0.6 + axis(flat_axis_));
    const glm::dvec3 place = flat_axis_ >= 0 ? middleOf(leaves_[random_() % leaves_.size()]) : outermost(out);
    const double height = diagonals * glm::length(box_.max - box_.min);
    const glm::dvec3 aside = glm::normalize(glm::cross(out, glm::dvec3(number(), number(), number())));
    core::View view;
    view.width_px = width_px_;
    view.height_px = height_px_;
    view.eye_model = place + out * height;
    view.forward = glm::normalize(place + aside * height * 0.4 - view.eye_model);
    view.up = glm::normalize(glm::cross(glm::cross(view.forward, out + aside), view.forward));
    return view;
  }

 private:
  double number() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  static glm::dvec3 axis(int which) { return {which == 0, which == 1, which == 2}; }
  static glm::dvec3 middleOf(const core::ModelBox& box) { return (box.min + box.max) / 2.0; }
  glm::dvec3 outermost(glm::dvec3 out) const {
    glm::dvec3 best = middleOf(leaves_.front());
    for (const core::ModelBox& leaf : leaves_)
      if (glm::dot(middleOf(leaf), out) > glm::dot(best, out)) best = middleOf(leaf);
    return best;
  }

  const double step_;
  const uint32_t width_px_, height_px_;
  core::ModelBox box_;
  int flat_axis_ = -1;
  std::vector<core::ModelBox> leaves_;
  std::mt19937 random_{1};
};

}  // namespace lode::bench
