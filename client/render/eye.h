#pragma once

#include <glm/glm.hpp>

#include "client/core/view/view.h"

namespace lode::render {

/// The eye in lattice steps, split so that a vertex minus the eye loses nothing where it matters: the integer
/// part is subtracted from lattice coordinates exactly, the rest in float. The same for every node of a
/// model, so that equal positions of neighbouring nodes land on equal pixels.
struct SplitEye {
  glm::ivec3 high{0};
  glm::vec3 low{0};
};

/// @param step  of the model's lattice, > 0. An eye beyond ±2^30 steps leaves the excess in `low`.
SplitEye splitEye(glm::dvec3 eye_model, double step) noexcept;

/// Model directions to view directions: x right, y up, z towards the viewer.
glm::mat3 viewRotation(const core::View& view) noexcept;

/// Scale of x and y, and the near distance, of a projection with reversed depth and no far plane:
/// clip = (scale.x * x, scale.y * y, near, -z) for a point in the view frame; depth is 1 at the near plane
/// and falls to 0.
struct Projection {
  glm::vec2 scale{1};
  float near_model = 0;
};

/// @param step  the near plane is never closer than one lattice step.
Projection reversedProjection(const core::View& view, double step) noexcept;

}  // namespace lode::render
