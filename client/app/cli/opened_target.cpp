#include "client/app/cli/opened_target.h"

#include <algorithm>
#include <limits>

#include "client/app/cli/target.h"
#include "client/core/view/framing.h"
#include "common/error.h"
#include "common/up_axis.h"

namespace lode::app {

core::Framing wantedFraming(const CommonOptions& options) {
  core::Framing framing;
  const PictureSize size = options.size();
  framing.aspect = static_cast<double>(size.width_px) / size.height_px;
  if (options.up_text.empty()) return framing;
  framing.up = parseAxis(options.up_text);
  if (!framing.up)
    throw Error(ErrorCode::kUsage,
                "'" + options.up_text + "' is not an axis; write --up y or z, or x, -x, -y, -z");
  return framing;
}

core::Framing framingOf(const Scene& scene, const CommonOptions& options) {
  if (scene.is_single_model) return wantedFraming(options);
  if (!options.up_text.empty())
    throw Error(ErrorCode::kUsage, options.target + ": the scene file sets the up axis; leave out --up");
  core::Framing framing = wantedFraming(options);
  framing.up = scene.up;
  return framing;
}

core::Framing frameCoarsely(core::Framing framing, stream::Streamer& streamer, const ModelSummary& model,
                            std::chrono::milliseconds timeout, const std::stop_token& stop) {
  constexpr std::chrono::milliseconds kLook{50};  // interval between checks of `stop`
  const core::CameraPath path = core::framingCamera(model, framing);
  const core::View view = core::toView(path.keys.front(), path.fov_y_deg, 1, 1, model);
  streamer.setView(view, std::numeric_limits<float>::max());
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  stream::StreamStatus status;
  const auto has_cut = [&] { return status.current && status.cut; };
  while (!has_cut() && !status.ended && !status.exhausted && !status.settled && !stop.stop_requested() &&
         std::chrono::steady_clock::now() < deadline)
    status = streamer.waitForCut(std::min(kLook, timeout));
  if (has_cut() && status.cut->parts.size() == 1) framing.coarse = status.cut->parts.front().mesh;
  return framing;
}

std::optional<core::CameraPath> wantedPath(const CommonOptions& options) {
  if (options.camera_file.empty()) return std::nullopt;
  return core::readCameraPath(options.camera_file);
}

OpenedTarget::OpenedTarget(const CommonOptions& options, const stream::StreamOptions& stream_options,
                           bool announce)
    : timeout_(options.timeout()),
      wanted_path_(wantedPath(options)),
      framing_(wantedFraming(options)),
      target_(resolveTarget(targetOf(options, options.target), stream_options, announce)),
      start_(Clock::now()),
      streamer_(target_.served, target_.options),
      model_(openModel(streamer_, target_, timeout_)) {
  if (!wanted_path_) {
    const auto spent = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - start_);
    frame(std::max(timeout_ - spent, std::chrono::milliseconds(0)));
  }
  path_ = wanted_path_ ? *wanted_path_ : core::framingCamera(model_, framing_);
}

void OpenedTarget::frame(std::chrono::milliseconds timeout) {
  framing_ = frameCoarsely(framing_, streamer_, model_, timeout);
  is_framed_ = true;
}

glm::dvec3 OpenedTarget::up() {
  if (!framing_.up && !is_framed_) frame(timeout_);
  return core::upOf(framing_);
}

core::View OpenedTarget::viewAt(double t, const PictureSize& size) const {
  return core::toView(core::cameraAt(path_, t), path_.fov_y_deg, size.width_px, size.height_px, model_);
}

}  // namespace lode::app
