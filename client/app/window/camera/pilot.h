#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "client/app/window/camera/camera_rig.h"
#include "client/app/window/camera/flight.h"
#include "client/app/window/scene/viewed_scene.h"
#include "client/app/window/view_command.h"
#include "client/core/view/camera_path.h"

namespace lode::app {

/// Flies the window's camera, from the first picture on, whatever the user does, and tells what the frames
/// took.
class Pilot {
 public:
  /// @param path  where to fly; none: an orbit.
  Pilot(const ViewOptions& options, std::optional<core::CameraPath> path);

  enum class State { kWaiting, kFlying, kOver };
  /// Takes the camera to where it is to be now.
  /// @throws Error once there can be no first picture any more: nothing more comes, or the time is over.
  State fly(const ViewedScene& scene, bool is_time_over, CameraRig& rig);

  /// It has had its first picture.
  bool isUnderWay() const noexcept { return flight_.has_value(); }

  /// A frame was drawn, whose work is told later: see Flight.
  void draw(uint64_t number, const FlownFrame& frame);
  void finish(uint64_t number, double work_ms);

  /// Prints what the frames took. @throws Error, then, unless the flight is over.
  void tell() const;

 private:
  using Clock = std::chrono::steady_clock;

  bool mayBegin(const ViewedScene& scene, bool is_time_over, const core::View& view) const;

  const ViewOptions options_;
  const std::optional<core::CameraPath> path_;
  std::optional<Flight> flight_;  ///< once there is a picture
  Clock::time_point start_;
};

}  // namespace lode::app
