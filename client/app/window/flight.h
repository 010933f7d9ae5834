#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "client/app/camera/camera_rig.h"
#include "client/app/window/scene/viewed_scene.h"
#include "client/app/window/view_command.h"
#include "client/core/view/camera_path.h"

namespace lode::app {

/// Measurements of one frame of a flight.
struct FlownFrame {
  int lap = 0;
  double t_s = 0;           ///< time on the camera path
  double work_ms = 0;       ///< frame time without waiting for the display
  double upload_ms = 0;     ///< time spent on uploads since the previous frame; included in work_ms
  double target_ms = 0;     ///< target frame time; 0: none
  double scale = 1;         ///< scale of the picture's width and height
  double threshold_px = 0;  ///< error threshold in pixels of the scaled picture
  uint64_t triangles = 0;
};

/// A camera path that the window's camera follows, and measurements of the frames drawn on the way. Pure: no
/// clock, no GL.
class Flight {
 public:
  /// @param laps  number of times to fly the path, >= 1.
  Flight(core::CameraPath path, int laps);

  /// Returns the camera at a time since the start of the flight, or nothing once the flight is over.
  std::optional<core::CameraKey> cameraAt(double seconds);
  /// Returns true once all laps are flown.
  bool isOver() const noexcept { return lap_ >= laps_; }
  double fovYDeg() const noexcept { return path_.fov_y_deg; }

  /// Adds a drawn frame; finish() sets the frame's work_ms later. Does nothing once the flight is over.
  void draw(uint64_t number, FlownFrame frame);
  /// Sets the work_ms of a frame. Ignores frames that draw() has not added.
  void finish(uint64_t number, double work_ms);

  /// Returns a line per lap: the number of frames, and statistics of frame times, upload times and
  /// thresholds.
  std::string describe() const;
  /// Returns the statistics of each lap, all frames, and whether the flight was interrupted.
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

/// Flies the window's camera along a path as soon as the window shows a first picture, and prints frame
/// times. The user cannot steer during the flight.
class Pilot {
 public:
  /// @param path  path to fly; an orbit if there is no path.
  Pilot(const ViewOptions& options, std::optional<core::CameraPath> path);

  enum class State { kWaiting, kFlying, kOver };
  /// Moves the camera along the path.
  /// @throws Error if there is no first picture and none can follow, because loading has ended or the time is
  /// over.
  State fly(const ViewedScene& scene, bool is_time_over, CameraRig& rig);

  /// Returns true once the flight has begun.
  bool isUnderWay() const noexcept { return flight_.has_value(); }

  /// Adds a drawn frame to the flight, like Flight::draw().
  void draw(uint64_t number, const FlownFrame& frame);
  void finish(uint64_t number, double work_ms);

  /// Prints the frame times. @throws Error if the flight has not begun, or, after printing, if it is not
  /// over.
  void print() const;

 private:
  using Clock = std::chrono::steady_clock;

  bool mayBegin(const ViewedScene& scene, bool is_time_over, const core::View& view) const;

  const ViewOptions options_;
  const std::optional<core::CameraPath> path_;
  std::optional<Flight> flight_;  ///< set when the flight begins
  Clock::time_point start_;
};

}  // namespace lode::app
