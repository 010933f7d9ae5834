#pragma once

#include <optional>
#include <string>

#include "client/core/view/camera_path.h"

namespace lode::app {

/// Returns a path as JSON. core::parseCameraPath() turns this JSON back into exactly the same path.
std::string writeCameraPath(const core::CameraPath& path);

/// Records a camera path for `render --frames` and `replay`.
class PathRecorder {
 public:
  bool recording() const noexcept { return path_.has_value(); }
  void start() { path_.emplace(); }
  /// Adds a camera as a key if a tenth of a second has passed since the last key and the path is not full.
  /// @param t_s  time in seconds from a monotonic clock
  void add(double t_s, core::CameraKey camera, double fov_y_deg);
  /// Ends the recording. @return the path, or nothing if the path has no keys.
  std::optional<core::CameraPath> finish();
  /// Ends the recording and writes the path into the current folder.
  /// @return the name of the file, or nothing if the path has no keys.
  /// @throws Error kIo, as AtomicFile does.
  std::optional<std::string> save();

 private:
  std::optional<core::CameraPath> path_;
  double start_s_ = 0;
};

}  // namespace lode::app
