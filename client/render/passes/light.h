#pragma once

#include <glm/glm.hpp>

#include "client/core/view/view.h"

namespace lode::render {

/// Directions of light in the view frame. The sun is above the viewer's left shoulder and turns with the
/// camera, so that no visible side of a model is dark. Sky and ground follow the model's up axis.
struct Light {
  glm::vec3 to_sun{0, 0, 1};  ///< unit vector
  glm::vec3 up{0, 1, 0};
};

/// @param up        the model's up axis in its own frame, not 0.
/// @param turn_rad  angles by which the sun is turned to the right and down, as the viewer sees it.
Light lightFor(const core::View& view, const glm::dvec3& up, const glm::dvec2& turn_rad = {0, 0}) noexcept;

/// GLSL code of the functions lit() and toned(), which shade a surface. Put this code before the code of a
/// mesh's fragment shader.
extern const char* const kLightShader;

}  // namespace lode::render
