#pragma once

#include <optional>
#include <string>

#include "client/core/view/camera_path.h"

namespace lode::app {

/// Notes where a camera goes, for `render --frames` and `replay`.
class PathRecorder {
 public:
  bool recording() const noexcept { return path_.has_value(); }
  void start() { path_.emplace(); }
  /// A camera at a time. Keys are a tenth of a second apart, and at most as many as a path may have.
  /// @param t_s  since any moment
  void see(double t_s, core::CameraKey camera, double fov_y_deg);
  /// Ends it. Nothing without a key.
  std::optional<core::CameraPath> finish();
  /// Ends it, and writes it into the current folder. @return the file; nothing without a key. @throws Error
  /// kIo.
  std::optional<std::string> save();

 private:
  std::optional<core::CameraPath> path_;
  double start_s_ = 0;
};

}  // namespace lode::app
