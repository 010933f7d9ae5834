#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "client/core/view/view.h"

namespace lode::app {

/// A line segment in a picture, in pixels from the picture's top left corner, y down. Its ends may lie
/// outside the picture.
struct PictureLine {
  glm::dvec2 from_px{0}, to_px{0};

  bool operator==(const PictureLine&) const = default;
};

/// Projects a point into the picture. The inverse of core::rayThrough().
/// @return the pixel position, or nothing if the point is nearer than view.near_model or behind the eye.
std::optional<glm::dvec2> pointInPicture(const core::View& view, const glm::dvec3& point_model) noexcept;

/// Projects the part of a segment that is in front of the eye. Returns nothing if the whole segment is behind
/// the eye.
std::optional<PictureLine> lineInPicture(const core::View& view, const glm::dvec3& from_model,
                                         const glm::dvec3& to_model) noexcept;

}  // namespace lode::app
