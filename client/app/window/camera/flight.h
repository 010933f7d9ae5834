#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "client/core/view/camera_path.h"

namespace lode::app {

/// One frame of a flight.
struct FlownFrame {
  int lap = 0;
  double t_s = 0;           ///< of the path
  double work_ms = 0;       ///< without the wait for the display
  double upload_ms = 0;     ///< of them: since the frame before
  double target_ms = 0;     ///< that it was to take at most; 0: whatever it takes
  double scale = 1;         ///< of the picture's sides,
  double threshold_px = 0;  ///< in the pixels of that
  uint64_t triangles = 0;
};

/// A camera path that a window flies, and what its frames took. Pure: no clock, no GL.
class Flight {
 public:
  /// @param laps  >= 1: how often the path is flown, from its first key each time.
  Flight(core::CameraPath path, int laps);

  /// The camera, so many seconds after the flight began; nothing once it is over.
  std::optional<core::CameraKey> cameraAt(double seconds);
  /// All laps are flown.
  bool isOver() const noexcept { return lap_ >= laps_; }
  double fovYDeg() const noexcept { return path_.fov_y_deg; }

  /// A frame was drawn whose work is told later, by its number; what is drawn once the flight is over is no
  /// frame of it.
  void draw(uint64_t number, FlownFrame frame);
  /// What a frame took; nothing is told of one that this flight did not draw.
  void finish(uint64_t number, double work_ms);

  /// A line for each lap: frames, their times, thresholds and uploads, medians, 99th percentiles and largest.
  std::string describe() const;
  /// The same, each frame, and whether it was interrupted.
  nlohmann::ordered_json toJson() const;

 private:
  struct UnderWay {
    uint64_t number = 0;
    FlownFrame frame;
  };

  core::CameraPath path_;
  int laps_, lap_ = 0;
  double t_s_ = 0;
  std::deque<UnderWay> under_way_;
  std::vector<FlownFrame> frames_;
};

}  // namespace lode::app
