#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace lode::app {

/// Histogram of durations from a microsecond to an hour. Each interval between two powers of two has 32 equal
/// buckets, so that the error of a percentile is at most 1/32. A histogram takes 7 KB. Source: HdrHistogram,
/// G. Tene.
class LatencyHistogram {
 public:
  void add(std::chrono::nanoseconds duration) noexcept;
  void add(const LatencyHistogram& other) noexcept;
  /// Returns a histogram of the durations that were added after `earlier`, an earlier copy of this histogram.
  /// The maximum of the result is still that of all durations.
  LatencyHistogram since(const LatencyHistogram& earlier) const noexcept;

  uint64_t count() const noexcept { return count_; }
  /// Returns the percentile in milliseconds; 0 for an empty histogram. @param part  fraction of the
  /// durations, from 0 to 1.
  double percentileMs(double part) const noexcept;
  double maxMs() const noexcept { return static_cast<double>(max_us_) * 1e-3; }

 private:
  static constexpr unsigned kPartBits = 5;  ///< 32 buckets per power of two
  /// Longest duration, in microseconds; longer durations count as this one.
  static constexpr uint64_t kMaxUs = (uint64_t{1} << 32) - 1;
  static constexpr size_t kBuckets = (32 - kPartBits + 1) << kPartBits;
  static size_t bucketOf(uint64_t us) noexcept;
  static uint64_t lastOf(size_t bucket) noexcept;

  std::array<uint64_t, kBuckets> counts_{};
  uint64_t count_ = 0, max_us_ = 0;
};

}  // namespace lode::app
