#pragma once

#include <chrono>
#include <optional>

namespace lode::serve {

/// Adds up the time for which somebody was held up.
class HoldClock {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;

  void start(Time now) noexcept {
    if (!since_) since_ = now;
  }
  void stop(Time now) noexcept {
    if (since_) before_ += now - *since_;
    since_.reset();
  }
  /// Up to now.
  Duration total(Time now) const noexcept { return since_ ? before_ + (now - *since_) : before_; }

 private:
  Duration before_{};
  std::optional<Time> since_;  ///< it is held up now
};

}  // namespace lode::serve
