#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include "client/core/view/time_point.h"

namespace lode::core {

/// Largest window: enough for 1 Gbit/s at a round trip of 85 ms, with kWindowGain.
constexpr uint64_t kMaxWindowBytes = 16u << 20;
constexpr double kWindowGain = 1.5;  ///< size of the window relative to rate × round trip
constexpr double kGrowthGain = 3;    ///< replaces kWindowGain while the measured rate still grows
/// Lower limit for the measured round trip, because thread scheduling dominates the measurement on a fast
/// link.
constexpr std::chrono::milliseconds kShortestTrip{10};
/// Shortest duration of a rate sample; a sample lasts one round trip if that is longer.
constexpr std::chrono::milliseconds kShortestSample{50};
constexpr size_t kRateSamples = 8;  ///< number of recent samples; the link's rate is their maximum

/// Flow control: computes how many unacknowledged bytes the server may send. This window is large enough to
/// fill the link, but small enough that urgent blobs do not queue behind other blobs. Derives the link's rate
/// from the received bytes. Not thread safe.
///
/// Source: Cardwell et al., BBR: Congestion-Based Congestion Control, 2016 (the largest recent rate and the
/// smallest round trip).
class CreditWindow {
 public:
  /// Counts the bytes received since the last call.
  void receive(uint64_t bytes, TimePoint now);
  /// Stops measuring the rate until bytes arrive again. Call it when no blob is awaited.
  void pause() noexcept { sample_begin_.reset(); }
  void measureTrip(std::chrono::nanoseconds trip) noexcept;

  /// Returns the size of the window.
  uint64_t bytes() const noexcept;
  /// Returns the measured rate of the link; 0: unknown.
  double bytesPerSecond() const noexcept;
  /// Returns the smallest measured round trip.
  std::optional<std::chrono::nanoseconds> roundTrip() const noexcept { return round_trip_; }

 private:
  std::chrono::nanoseconds sampleTime() const noexcept;

  std::optional<std::chrono::nanoseconds> round_trip_;
  std::optional<TimePoint> sample_begin_;
  uint64_t sample_bytes_ = 0;  // bytes received since sample_begin_
  std::deque<double> rates_;   // measured rates in bytes per second, newest last
  bool growing_ = true;        // the newest sample is much faster than all earlier samples
};

}  // namespace lode::core
