#pragma once

#include <glm/glm.hpp>

#include "client/core/view/view.h"

namespace lode::render {

/// The eye in lattice steps, split into an integer part and a remainder. Shaders subtract the integer part
/// from lattice coordinates exactly and the remainder in float. All nodes of a model use the same split, so
/// that equal positions of neighbouring nodes are drawn at equal places.
struct SplitEye {
  glm::ivec3 high{0};
  glm::vec3 low{0};
};

/// @param step  the model's lattice step, > 0. If the eye is beyond ±2^30 steps, `low` contains the
/// excess.
SplitEye splitEye(glm::dvec3 eye_model, double step) noexcept;

/// Rotates model directions into the view frame: x right, y up, z towards the viewer.
glm::mat3 viewRotation(const core::View& view) noexcept;

/// A projection with reversed depth and without a far plane, given by the scale of x and y and the near
/// distance. A point (x, y, z) of the view frame has the clip coordinates (scale.x * x, scale.y * y, near,
/// -z). Depth is 1 at the near plane and approaches 0 with distance.
struct Projection {
  glm::vec2 scale{1};
  float near_model = 0;
};

/// @param step  lattice step of the model; the near plane is at least this far from the eye.
Projection reversedProjection(const core::View& view, double step) noexcept;

}  // namespace lode::render
