#pragma once

#include <array>
#include <chrono>
#include <cstddef>

#include "client/core/view/time_point.h"

namespace lode::core {

/// What stands between a view and its converged picture.
enum class Waiting : size_t {
  kNot,     ///< it has converged, or there is no view
  kLink,    ///< bytes are awaited, from the server or for a connection to it
  kDecode,  ///< bytes are there and not decoded yet
  kBudget,  ///< all is there that the memory allows
};
constexpr size_t kWaitings = 4;

/// How long it was waited for what.
class WaitTimes {
 public:
  using Duration = std::chrono::nanoseconds;

  /// From now on, until the next call.
  void begin(Waiting waiting, TimePoint now) noexcept {
    if (begun_) times_[static_cast<size_t>(waiting_)] += now - since_;
    begun_ = true;
    waiting_ = waiting;
    since_ = now;
  }
  Duration of(Waiting waiting) const noexcept { return times_[static_cast<size_t>(waiting)]; }

 private:
  std::array<Duration, kWaitings> times_{};
  bool begun_ = false;
  Waiting waiting_ = Waiting::kNot;
  TimePoint since_{};
};

}  // namespace lode::core
