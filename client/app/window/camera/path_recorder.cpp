#include "client/app/window/camera/path_recorder.h"

#include <fstream>
#include <utility>

#include "client/app/window/camera/camera_path_writer.h"
#include "client/app/window/output/picture_file.h"
#include "common/error.h"

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

std::optional<std::string> PathRecorder::save() {
  const std::optional<core::CameraPath> path = finish();
  if (!path) return std::nullopt;
  const std::string file = timedName("json");
  std::ofstream stream(file, std::ios::binary);
  stream << core::writeCameraPath(*path) << std::flush;
  if (!stream)
    throw Error(ErrorCode::kIo,
                file + " cannot be written: start the window in a folder where files can be made");
  return file;
}

}  // namespace lode::app
