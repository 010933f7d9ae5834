#include "client/app/window/path_recorder.h"

#include <utility>

namespace lode::app {

void PathRecorder::see(double t_s, const core::View& view, double distance_model, const glm::dvec3& origin) {
  constexpr double kKeySeconds = 0.1;
  if (!path_) return;
  auto& keys = path_->keys;
  if (keys.empty()) {
    start_s_ = t_s;
    path_->fov_y_deg = glm::degrees(view.fov_y_rad);
  }
  const bool is_due = keys.empty() || t_s - start_s_ >= keys.back().t + kKeySeconds;
  if (!is_due || keys.size() == core::kMaxCameraKeys) return;
  const glm::dvec3 eye = origin + view.eye_model;
  keys.push_back({t_s - start_s_, eye, eye + view.forward * distance_model, view.up});
}

std::optional<core::CameraPath> PathRecorder::finish() {
  std::optional<core::CameraPath> path = std::exchange(path_, std::nullopt);
  if (path && path->keys.empty()) path.reset();
  return path;
}

}  // namespace lode::app
