#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "client/render/gl_names.h"

namespace lode::render {

/// What frames take on the GPU, by queries that are answered some frames later. Never waits. Used on the
/// thread of its context.
class FrameTimer {
 public:
  FrameTimer();

  /// What is drawn from here to end() is timed, unless as many frames as fit are still under way.
  /// @param coarsening  of the frame, told again with its time.
  /// @return its number, if it is timed: told again with its time, too, and never that of another.
  std::optional<uint64_t> begin(double coarsening);
  /// @param cpu_ms       what the frame took on this thread.
  /// @param is_complete  of what it shows, told again, too: see FrameRateControl.
  void end(double cpu_ms, bool is_complete = true);

  struct Timed {
    uint64_t number = 0;
    double gpu_ms = 0, cpu_ms = 0, coarsening = 1;
    bool is_complete = true;
  };
  /// The oldest frame that is not yet told of, if its time is known.
  std::optional<Timed> take();
  /// Waits until the times of all frames that have ended are known.
  void wait();

 private:
  struct UnderWay {
    GlTimeQuery query;
    Timed frame;
  };
  std::array<UnderWay, 4> ring_;
  uint64_t begun_ = 0, told_ = 0;
  bool timing_ = false;
};

}  // namespace lode::render
