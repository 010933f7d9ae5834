#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "client/core/camera_path.h"

namespace lode::app {

/// Notes where a camera goes, for `render --frames` and `replay`.
class PathRecorder {
 public:
  bool recording() const noexcept { return path_.has_value(); }
  void start() { path_.emplace(); }
  /// A camera at a time. Keys are a tenth of a second apart, and at most as many as a path may have.
  /// @param t_s         since any moment
  /// @param distance_model  of what it looks at
  /// @param origin      of the model frame, in true coordinates
  void see(double t_s, const core::View& view, double distance_model, const glm::dvec3& origin);
  /// Ends it. Nothing without a key.
  std::optional<core::CameraPath> finish();

 private:
  std::optional<core::CameraPath> path_;
  double start_s_ = 0;
};

}  // namespace lode::app
