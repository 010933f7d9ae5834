#pragma once

#include <algorithm>
#include <chrono>

namespace lode::ingest {

/// When a build should note how far a stage is: after work of a hundred times what the last note took, so
/// that notes cost a hundredth of the time on any disk; but every ten seconds at the latest, so that a kill
/// costs no more.
class CheckpointClock {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr Clock::duration kLatest = std::chrono::seconds(10);

  explicit CheckpointClock(Clock::time_point now) : due_(now + kSoonest) {}

  bool isDue(Clock::time_point now) const noexcept { return now >= due_; }
  void noted(Clock::time_point began, Clock::time_point ended) noexcept {
    due_ = ended + std::clamp<Clock::duration>(kWorkOfNote * (ended - began), kSoonest, kLatest);
  }

 private:
  static constexpr int kWorkOfNote = 100;
  static constexpr Clock::duration kSoonest = std::chrono::milliseconds(50);

  Clock::time_point due_;
};

}  // namespace lode::ingest
