#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/app/window/scene/picks.h"
#include "client/app/window/scene/projection.h"

namespace lode::app {

/// Where what is measured shows in a picture.
struct PickMarks {
  std::vector<glm::dvec2> points_px;      ///< of those in front of the eye
  std::optional<core::PictureLine> line;  ///< between two points,
  std::string distance;                   ///< and how long it is

  bool operator==(const PickMarks&) const = default;
};

PickMarks marksOf(const Picks& picks, const core::View& view);

/// Where a text of a size hides nothing of a line, by its middle, and is in the window, where that has room.
/// @param gap  between the line and the text. @return the text's upper left corner.
glm::dvec2 besideLine(const core::PictureLine& line, const glm::dvec2& text, const glm::dvec2& window,
                      double gap) noexcept;

}  // namespace lode::app
