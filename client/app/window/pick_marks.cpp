#include "client/app/window/pick_marks.h"

namespace lode::app {

PickMarks marksOf(const Picks& picks, const core::View& view) {
  PickMarks marks;
  for (const PickedPoint& point : picks.points())
    if (const auto place_px = core::placeInPicture(view, point.position_model))
      marks.points_px.push_back(*place_px);
  if (picks.points().size() == 2) {
    marks.line =
        core::lineInPicture(view, picks.points()[0].position_model, picks.points()[1].position_model);
    marks.distance = picks.distance();
  }
  return marks;
}

}  // namespace lode::app
