#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace lode::app {

/// Histogram of durations from a microsecond to an hour. Each power of two has 32 equal buckets, so that
/// percentiles are exact to 1/32. A histogram takes 8 KB. Source: HdrHistogram, G. Tene.
class LatencyHistogram {
 public:
  void add(std::chrono::nanoseconds duration) noexcept;
  void add(const LatencyHistogram& other) noexcept;
  /// Returns a histogram of the durations that were added since `earlier`, an earlier copy of this histogram.
  /// Its maximum is the maximum of all durations.
  LatencyHistogram since(const LatencyHistogram& earlier) const noexcept;

  uint64_t count() const noexcept { return count_; }
  /// Returns the percentile in milliseconds; 0 for an empty histogram. @param part  0 to 1.
  double percentileMs(double part) const noexcept;
  double maxMs() const noexcept { return static_cast<double>(max_us_) * 1e-3; }

 private:
  static constexpr unsigned kPartBits = 5;                     ///< 32 buckets per power of two
  static constexpr uint64_t kMaxUs = (uint64_t{1} << 32) - 1;  ///< longest duration in the histogram; longer
                                                               ///< durations count as this one
  static constexpr size_t kBuckets = (32 - kPartBits + 1) << kPartBits;
  static size_t bucketOf(uint64_t us) noexcept;
  static uint64_t lastOf(size_t bucket) noexcept;

  std::array<uint64_t, kBuckets> counts_{};
  uint64_t count_ = 0, max_us_ = 0;
};

}  // namespace lode::app
