#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "client/app/window/camera/camera_rig.h"
#include "client/app/window/scene/viewed_scene.h"
#include "client/app/window/view_command.h"
#include "client/core/view/camera_path.h"

namespace lode::app {

/// A frame of a flight.
struct FlownFrame {
  int lap = 0;
  double t_s = 0;           ///< path time
  double work_ms = 0;       ///< frame time without waiting for the display
  double upload_ms = 0;     ///< part of it spent on uploads since the previous frame
  double target_ms = 0;     ///< target frame time; 0: none
  double scale = 1;         ///< resolution scale per side
  double threshold_px = 0;  ///< in scaled pixels
  uint64_t triangles = 0;
};

/// A camera path that a window follows, and the times of its frames. Pure: no clock, no GL.
class Flight {
 public:
  /// @param laps  >= 1: number of times the path is flown, each from its first key.
  Flight(core::CameraPath path, int laps);

  /// Returns the camera at a time since the start; nothing once the flight is over.
  std::optional<core::CameraKey> cameraAt(double seconds);
  /// True once all laps are flown.
  bool isOver() const noexcept { return lap_ >= laps_; }
  double fovYDeg() const noexcept { return path_.fov_y_deg; }

  /// Adds a frame that was drawn; finish() adds its time later. Ignored once the flight is over.
  void draw(uint64_t number, FlownFrame frame);
  /// Sets the time of a frame. Ignores frames that draw() did not add.
  void finish(uint64_t number, double work_ms);

  /// Returns a line per lap: frames; median, 99th percentile and maximum of frame times, uploads and
  /// thresholds.
  std::string describe() const;
  /// Returns the same figures, each frame, and whether the flight was interrupted.
  nlohmann::ordered_json toJson() const;

 private:
  struct Pending {
    uint64_t number = 0;
    FlownFrame frame;
  };

  core::CameraPath path_;
  int laps_, lap_ = 0;
  double t_s_ = 0;
  std::deque<Pending> pending_;
  std::vector<FlownFrame> frames_;
};

/// Flies the window's camera from the first picture on, ignoring the user, and prints frame times.
class Pilot {
 public:
  /// @param path  path to fly; none: an orbit.
  Pilot(const ViewOptions& options, std::optional<core::CameraPath> path);

  enum class State { kWaiting, kFlying, kOver };
  /// Moves the camera along the path.
  /// @throws Error if there will be no first picture: nothing more loads, or the time is over.
  State fly(const ViewedScene& scene, bool is_time_over, CameraRig& rig);

  /// True after the first picture.
  bool isUnderWay() const noexcept { return flight_.has_value(); }

  /// See Flight.
  void draw(uint64_t number, const FlownFrame& frame);
  void finish(uint64_t number, double work_ms);

  /// Prints the frame times. @throws Error afterwards if the flight is not over.
  void print() const;

 private:
  using Clock = std::chrono::steady_clock;

  bool mayBegin(const ViewedScene& scene, bool is_time_over, const core::View& view) const;

  const ViewOptions options_;
  const std::optional<core::CameraPath> path_;
  std::optional<Flight> flight_;  ///< set at the first picture
  Clock::time_point start_;
};

}  // namespace lode::app
