#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "client/render/gl_names.h"
#include "client/render/shown_thresholds.h"

namespace lode::render {

/// What frames take on the GPU, by queries that are answered some frames later. Never waits. Used on the
/// thread of its context.
class FrameTimer {
 public:
  FrameTimer();

  /// What is drawn from here to end() is timed, unless as many frames as fit are still under way.
  /// @return its number, if it is timed: told again with its time, too, and never that of another.
  std::optional<uint64_t> begin();
  /// @param cpu_ms      what the frame took on this thread.
  /// @param coarsening  of what it shows, told again with its time.
  void end(double cpu_ms, std::optional<Coarsening> coarsening);

  struct Timed {
    uint64_t number = 0;
    double gpu_ms = 0, cpu_ms = 0;
    std::optional<Coarsening> coarsening;
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
