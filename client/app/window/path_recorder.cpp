#include "client/app/window/path_recorder.h"

#include <utility>

namespace lode::app {

void PathRecorder::see(double t_s, core::CameraKey camera, double fov_y_deg) {
  constexpr double kKeySeconds = 0.1;
  if (!path_) return;
  auto& keys = path_->keys;
  if (keys.empty()) {
    start_s_ = t_s;
    path_->fov_y_deg = fov_y_deg;
  }
  const bool is_due = keys.empty() || t_s - start_s_ >= keys.back().t + kKeySeconds;
  if (!is_due || keys.size() == core::kMaxCameraKeys) return;
  camera.t = t_s - start_s_;
  keys.push_back(camera);
}

std::optional<core::CameraPath> PathRecorder::finish() {
  std::optional<core::CameraPath> path = std::exchange(path_, std::nullopt);
  if (path && path->keys.empty()) path.reset();
  return path;
}

}  // namespace lode::app
