#include "client/app/window/panel/pick_marks.h"

namespace lode::app {

PickMarks marksOf(const Picks& picks, const core::View& view) {
  PickMarks marks;
  for (const PickedPoint& point : picks.points())
    if (const auto place_px = core::pointInPicture(view, point.position_model))
      marks.points_px.push_back(*place_px);
  if (picks.points().size() == 2) {
    marks.line =
        core::lineInPicture(view, picks.points()[0].position_model, picks.points()[1].position_model);
    marks.distance = picks.distance();
  }
  return marks;
}

glm::dvec2 besideLine(const core::PictureLine& line, const glm::dvec2& text, const glm::dvec2& window,
                      double gap) noexcept {
  const glm::dvec2 along = line.to_px - line.from_px;
  const double length = glm::length(along);
  glm::dvec2 aside = length > 0 ? glm::dvec2(-along.y, along.x) / length : glm::dvec2(0, 1);
  if (aside.y < 0) aside = -aside;
  const glm::dvec2 middle = (line.from_px + line.to_px) / 2.0;
  const glm::dvec2 corner = middle + aside * (glm::dot(glm::abs(aside), text) / 2 + gap) - text / 2.0;
  return glm::clamp(corner, glm::dvec2(gap), glm::max(glm::dvec2(gap), window - text - gap));
}

}  // namespace lode::app
