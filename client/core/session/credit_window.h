#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include "client/core/view/time_point.h"

namespace lode::core {

constexpr uint64_t kMaxWindowBytes = 16u << 20;  ///< enough for 1 Gbit/s at 85 ms, with kWindowGain
constexpr double kWindowGain = 1.5;              ///< window / (rate × round trip)
constexpr double kGrowthGain = 3;                ///< the same while the measured rate still grows
/// Shorter round trips count as this one: on a fast link, thread scheduling dominates.
constexpr std::chrono::milliseconds kShortestTrip{10};
constexpr std::chrono::milliseconds kShortestSample{50};  ///< rate sample; a round trip if longer
constexpr size_t kRateSamples = 8;                        ///< the rate is the maximum of the last samples

/// Flow control: computes how many unacknowledged bytes the server may send. Enough to fill the link, but few
/// enough that urgent blobs do not queue behind others. Measures the link by the received bytes. Not thread
/// safe.
///
/// Source: Cardwell et al., BBR: Congestion-Based Congestion Control, 2016 (the largest rate and the smallest
/// round trip, each over a while).
class CreditWindow {
 public:
  /// Counts bytes received until `now`.
  void receive(uint64_t bytes, TimePoint now);
  /// Stops measuring until bytes arrive again, since no blob is awaited.
  void pause() noexcept { sample_begin_.reset(); }
  void measureTrip(std::chrono::nanoseconds trip) noexcept;

  /// The window.
  uint64_t bytes() const noexcept;
  /// Measured rate of the link; 0: unknown.
  double bytesPerSecond() const noexcept;
  /// The smallest measured round trip.
  std::optional<std::chrono::nanoseconds> roundTrip() const noexcept { return round_trip_; }

 private:
  std::chrono::nanoseconds sampleTime() const noexcept;

  std::optional<std::chrono::nanoseconds> round_trip_;
  std::optional<TimePoint> sample_begin_;
  uint64_t sample_bytes_ = 0;  // received since sample_begin_
  std::deque<double> rates_;   // bytes per second, newest last
  bool growing_ = true;        // the newest sample is much faster than all before
};

}  // namespace lode::core
