#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "client/render/draw_counts.h"
#include "client/render/gl/gl_names.h"

namespace lode::render {

/// Measures the GPU time of frames with timer queries. The results arrive a few frames later. Only wait()
/// blocks. Use the object on the thread of its OpenGL context.
class FrameTimer {
 public:
  FrameTimer();

  /// Starts timing a frame, unless results of too many earlier frames are still pending.
  /// @return the frame's unique number, which take() returns with the time; nothing if the frame is not
  /// timed.
  std::optional<uint64_t> begin();
  /// @param cpu_ms      time that the frame took on this thread.
  /// @param coarsening  the frame's coarsening, which take() returns with the time.
  void end(double cpu_ms, std::optional<Coarsening> coarsening);

  struct Timed {
    uint64_t number = 0;
    double gpu_ms = 0, cpu_ms = 0;
    std::optional<Coarsening> coarsening;
  };
  /// Returns the oldest frame not yet taken, if its result is available.
  std::optional<Timed> take();
  /// Blocks until the results of all ended frames are available.
  void wait();

 private:
  struct Pending {
    GlTimeQuery query;
    Timed frame;
  };
  std::array<Pending, 4> ring_;
  uint64_t begun_ = 0, taken_ = 0;
  bool timing_ = false;
};

}  // namespace lode::render
