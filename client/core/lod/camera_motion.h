#pragma once

#include <chrono>
#include <deque>
#include <optional>

#include "client/core/view/time_point.h"
#include "client/core/view/view.h"

namespace lode::core {

/// How a camera moves, by where it was in the last moments, and where it will be if it goes on like this. Not
/// thread safe.
class CameraMotion {
 public:
  void see(const View& view, TimePoint now);
  /// It goes on in a helix: with the velocity and the turn of the last moments, both as seen from the camera.
  /// @return nothing while the camera stands still or has jumped.
  std::optional<View> predict(TimePoint now, std::chrono::duration<double> ahead) const;

 private:
  struct Seen {
    View view;
    TimePoint at;
  };
  std::deque<Seen> seen_;  // oldest first
};

}  // namespace lode::core
