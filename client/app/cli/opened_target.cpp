#include "client/app/cli/opened_target.h"

#include "client/app/cli/first_camera.h"
#include "client/app/cli/target.h"
#include "client/core/view/framing.h"

namespace lode::app {
std::optional<core::CameraPath> wantedPath(const CommonOptions& options) {
  if (options.camera_file.empty()) return std::nullopt;
  return core::readCameraPath(options.camera_file);
}

OpenedTarget::OpenedTarget(const CommonOptions& options, const stream::StreamOptions& stream_options,
                           bool announce)
    : timeout_(options.timeout()),
      wanted_path_(wantedPath(options)),
      framing_(wantedFraming(options)),
      target_(resolveTarget(parseTarget(options.target), stream_options, announce)),
      start_(Clock::now()),
      streamer_(target_.served, target_.options),
      model_(openModel(streamer_, target_, timeout_)) {
  if (!wanted_path_) frame();
  path_ = wanted_path_ ? *wanted_path_ : core::framingCamera(model_, framing_);
}

void OpenedTarget::frame() {
  framing_ = frameCoarsely(framing_, streamer_, model_, timeout_);
  is_framed_ = true;
}

glm::dvec3 OpenedTarget::up() {
  if (!framing_.up && !is_framed_) frame();
  return core::upOf(framing_);
}

core::View OpenedTarget::viewAt(double t, const PictureSize& size) const {
  return core::toView(core::cameraAt(path_, t), path_.fov_y_deg, size.width_px, size.height_px, model_);
}

}  // namespace lode::app
