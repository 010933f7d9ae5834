#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/app/window/panel/projection.h"
#include "client/app/window/scene/picks.h"

struct ImVec4;

namespace lode::app {

/// Marks of a measurement in the picture.
struct PickMarks {
  std::vector<glm::dvec2> points_px;  ///< picked points in front of the eye
  std::optional<PictureLine> line;    ///< line between the two points
  std::string distance;               ///< length of the line as text

  bool operator==(const PickMarks&) const = default;
};

/// Projects the picks into a view's picture.
PickMarks marksOf(const Picks& picks, const core::View& view);

/// Places a text beside the middle of a line, so that the text does not cover the line and, if possible, is
/// inside the window. @param text  size of the text. @param gap  distance between text and line.
/// @return the upper left corner of the text.
glm::dvec2 besideLine(const PictureLine& line, const glm::dvec2& text, const glm::dvec2& window,
                      double gap) noexcept;

/// Draws marks over the picture and below the panel, within an ImGui frame. A dark outline keeps the marks
/// legible on any model.
void drawMarks(const PickMarks& marks, const ImVec4& colour);

}  // namespace lode::app
