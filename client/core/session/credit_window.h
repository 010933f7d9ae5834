#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include "client/core/view/time_point.h"

namespace lode::core {

constexpr uint64_t kMaxWindowBytes = 16u << 20;  ///< a gigabit a second over 85 ms
constexpr double kWindowGain = 1.5;              ///< of rate × round trip
constexpr double kGrowthGain = 3;                ///< while each sample is faster than those before
/// Round trips below count as it: what keeps a fast link waiting is the threads at its ends.
constexpr std::chrono::milliseconds kShortestTrip{10};
constexpr std::chrono::milliseconds kShortestSample{50};  ///< of the rate; a round trip where that is longer
constexpr size_t kRateSamples = 8;                        ///< the fastest of the last ones counts

/// How many bytes a server may have under way to a client: enough to fill the link, and so few that what is
/// requested urgently does not wait behind the rest. Measures the link by what comes over it. Not thread
/// safe.
///
/// Source: Cardwell et al., BBR: Congestion-Based Congestion Control, 2016 (the largest rate and the smallest
/// round trip, each over a while).
class CreditWindow {
 public:
  /// So many bytes have come by now.
  void receive(uint64_t bytes, TimePoint now);
  /// Nothing is awaited: until bytes come again the link is not measured.
  void pause() noexcept { sample_begin_.reset(); }
  void measureTrip(std::chrono::nanoseconds trip) noexcept;

  /// What the server may have under way.
  uint64_t bytes() const noexcept;
  /// Of the link, as far as it was measured; 0: not yet.
  double bytesPerSecond() const noexcept;
  /// The smallest so far.
  std::optional<std::chrono::nanoseconds> roundTrip() const noexcept { return round_trip_; }

 private:
  std::chrono::nanoseconds sampleTime() const noexcept;

  std::optional<std::chrono::nanoseconds> round_trip_;
  std::optional<TimePoint> sample_begin_;
  uint64_t sample_bytes_ = 0;  // since then
  std::deque<double> rates_;   // bytes a second, the newest last
  bool growing_ = true;        // the newest sample is much faster than any before
};

}  // namespace lode::core
