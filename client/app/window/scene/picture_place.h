#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "client/core/view/view.h"

namespace lode::core {

/// A line between two places of a picture, pixels from its top left corner, y down; they may lie outside it.
struct PictureLine {
  glm::dvec2 from_px{0}, to_px{0};

  bool operator==(const PictureLine&) const = default;
};

/// Where a point shows: what rayThrough() asks, the other way round.
/// @return nothing if it is not in front of the eye by view.near_model.
std::optional<glm::dvec2> placeInPicture(const View& view, const glm::dvec3& point_model) noexcept;

/// Where the part of a segment shows that is in front of the eye; nothing if none is.
std::optional<PictureLine> lineInPicture(const View& view, const glm::dvec3& from_model,
                                         const glm::dvec3& to_model) noexcept;

}  // namespace lode::core
