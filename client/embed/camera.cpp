#include "client/embed/camera.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "client/core/view/camera_path.h"
#include "common/error.h"

namespace lode::embed {
namespace {

glm::dvec3 toVector(const double (&values)[3]) { return {values[0], values[1], values[2]}; }

}  // namespace

core::View toView(const lodestream_view& view, const ModelSummary& model) {
  const auto isFinite = [](const double(&values)[3]) {
    return std::all_of(std::begin(values), std::end(values),
                       [](double value) { return std::isfinite(value); });
  };
  const bool has_size = std::clamp(view.width_px, 1u, core::kMaxPictureSidePx) == view.width_px &&
                        std::clamp(view.height_px, 1u, core::kMaxPictureSidePx) == view.height_px;
  if (!isFinite(view.eye) || !isFinite(view.target) || !isFinite(view.up) || !has_size ||
      !(view.fov_y_deg >= core::kMinFovDeg && view.fov_y_deg <= core::kMaxFovDeg) || !(view.threshold_px > 0))
    throw Error(
        ErrorCode::kUsage,
        "this is no view: it needs finite vectors, a picture of 1 to 32768 pixels each way, an angle of "
        "0.01 to 170 degrees and a threshold above 0; set none while a window has no pixels");
  const core::CameraKey camera{0, toVector(view.eye), toVector(view.target), toVector(view.up)};
  return core::toView(camera, view.fov_y_deg, view.width_px, view.height_px, model);
}

}  // namespace lode::embed
