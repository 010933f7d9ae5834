#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "client/app/window/panel/projection.h"
#include "client/app/window/scene/measure.h"

struct ImVec4;

namespace lode::app {

/// Marks that show a measurement in the picture.
struct PickMarks {
  std::vector<glm::dvec2> points_px;  ///< positions of the picked points that are in front of the eye
  std::vector<PictureLine> lines;     ///< lines between the points, as far as they are in front of the eye
  std::string value;                  ///< value as text, for the last line

  bool operator==(const PickMarks&) const = default;
};

/// Projects a measurement into a view's picture. @param up  up axis. @param unit  unit of length; may be
/// empty.
PickMarks marksOf(const Measure& measure, const glm::dvec3& up, std::string_view unit,
                  const core::View& view);

/// Places a text beside the middle of a line, where it does not cover the line. Moves the text into the
/// window if necessary. @param text  size of the text. @param gap  least distance between the text and the
/// line, and between the text and the window's edge.
/// @return the upper left corner of the text.
glm::dvec2 besideLine(const PictureLine& line, const glm::dvec2& text, const glm::dvec2& window,
                      double gap) noexcept;

/// Draws marks over the picture and below the panel, within an ImGui frame. A dark outline keeps the marks
/// legible on any model.
void drawMarks(const PickMarks& marks, const ImVec4& colour);

}  // namespace lode::app
