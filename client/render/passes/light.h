#pragma once

#include <glm/glm.hpp>

#include "client/core/view/view.h"

namespace lode::render {

/// Where the light of a picture comes from, in the view frame. The sun stands over the viewer's left shoulder
/// and goes round with the camera, so that no side of a model lies in the dark; the sky is above and the
/// ground below as the model stands.
struct Light {
  glm::vec3 to_sun{0, 0, 1};  ///< unit length, as below
  glm::vec3 up{0, 1, 0};
};

/// @param up  of the model, in its frame, of any length but 0.
Light lightFor(const core::View& view, const glm::dvec3& up) noexcept;

}  // namespace lode::render
