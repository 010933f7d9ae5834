#pragma once

#include <chrono>
#include <deque>
#include <optional>

#include "client/core/view/time_point.h"
#include "client/core/view/view.h"

namespace lode::core {

/// Predicts the future view of a camera from its recent views. Not thread safe.
class CameraMotion {
 public:
  void record(const View& view, TimePoint now);
  /// Extrapolates the motion with constant velocity and rotation in the camera's own frame, so that the path
  /// is a helix.
  /// @return nothing if the camera does not move, or if the camera has jumped.
  std::optional<View> predict(TimePoint now, std::chrono::duration<double> ahead) const;

 private:
  struct Seen {
    View view;
    TimePoint at;
  };
  std::deque<Seen> seen_;  // oldest first
};

}  // namespace lode::core
