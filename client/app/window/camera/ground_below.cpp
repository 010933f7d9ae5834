#include "client/app/window/camera/ground_below.h"

#include <algorithm>
#include <cmath>

#include "client/core/lod/cut.h"

namespace lode::app {
namespace {

constexpr double kMostUncertain = 0.01;  ///< of a part's size: hardly a level errs by more

/// What a part's projected error was before its projection. A part around the eye of its view was as near as
/// anything can be, which tells little: its size limits it.
double uncertaintyOf(const core::CutPart& part, const core::View& view, double step) {
  LatticeBox lattice_box;
  for (const PositionCode code : part.mesh->positions) lattice_box.add(unpackPosition(code));
  const core::ModelBox box = core::toModelBox(lattice_box, step);
  const double distance_model = std::max(core::distanceToBox(view.eye_model, box), view.near_model);
  const double model_per_px =
      2 * distance_model * std::tan(view.fov_y_rad / 2) / std::max(1u, view.height_px);
  return std::min(part.error_px * model_per_px, kMostUncertain * glm::distance(box.min, box.max));
}

}  // namespace

std::optional<render::Ground> groundBelow(const core::CutProbe& probe, const core::View& view,
                                          const glm::dvec3& point_model, const glm::dvec3& up) {
  core::View down = view;
  down.eye_model = point_model;
  down.forward = -up;
  const glm::dvec3 aside = std::abs(up.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  down.up = glm::normalize(aside - up * glm::dot(aside, up));
  const core::Cut& cut = *probe.cut();
  const std::optional<core::Hit> hit = probe.cast({point_model, -up}, core::shownParts(cut, down));
  if (!hit) return std::nullopt;
  return render::Ground{hit->distance_model, uncertaintyOf(*hit->part, cut.view, probe.step())};
}

}  // namespace lode::app
