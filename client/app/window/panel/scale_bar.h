#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include <glm/glm.hpp>

#include "client/core/view/view.h"

namespace lode::app {

/// A bar that shows a length at a distance from the eye.
struct ScaleBar {
  double length_px = 0;
  std::string text;

  bool operator==(const ScaleBar&) const = default;
};

/// Returns the longest bar of 1, 2 or 5 times a power of ten that is at most `most_px` long; nothing if there
/// is none. Pure.
/// @param distance_model  distance along the view direction at which lengths are shown. @param unit  unit of
///                        length; may be empty.
std::optional<ScaleBar> scaleBarOf(const core::View& view, double distance_model, double most_px,
                                   std::string_view unit);

/// Directions of the x, y and z axes in the picture: x to the right, y down, z away from the viewer. The
/// length of each vector is 1. Pure.
std::array<glm::dvec3, 3> axesInPicture(const core::View& view) noexcept;

/// The scale bar and the axes of a picture.
struct ScaleMarks {
  std::optional<ScaleBar> bar;
  std::array<glm::dvec3, 3> axes{};

  bool operator==(const ScaleMarks&) const = default;
};

/// Draws the marks at the bottom right of the picture, below the panel, within an ImGui frame.
void drawScale(const ScaleMarks& marks);

}  // namespace lode::app
