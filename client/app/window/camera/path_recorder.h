#pragma once

#include <optional>
#include <string>

#include "client/core/view/camera_path.h"

namespace lode::app {

/// Writes a path as JSON. core::parseCameraPath() reads it back exactly.
std::string writeCameraPath(const core::CameraPath& path);

/// Records a camera path for `render --frames` and `replay`.
class PathRecorder {
 public:
  bool recording() const noexcept { return path_.has_value(); }
  void start() { path_.emplace(); }
  /// Adds a camera as a key if a tenth of a second has passed since the last key and the path is not full.
  /// @param t_s  time from a monotonic clock
  void add(double t_s, core::CameraKey camera, double fov_y_deg);
  /// Ends the recording. @return nothing if it has no key.
  std::optional<core::CameraPath> finish();
  /// Ends the recording and writes it into the current folder. @return the file; nothing if it has no key.
  /// @throws Error kIo.
  std::optional<std::string> save();

 private:
  std::optional<core::CameraPath> path_;
  double start_s_ = 0;
};

}  // namespace lode::app
