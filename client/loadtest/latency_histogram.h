#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace lode::app {

/// Durations counted in buckets whose width grows with what they hold, so that any percentile of any number
/// of them is known to a thirty-second of itself, from a microsecond to an hour, in 8 KB. Source:
/// HdrHistogram, G. Tene: the idea, one power of two split into equal parts.
class LatencyHistogram {
 public:
  void add(std::chrono::nanoseconds duration) noexcept;
  void add(const LatencyHistogram& other) noexcept;
  /// What was added since an earlier state of this; the longest stays that of all.
  LatencyHistogram since(const LatencyHistogram& earlier) const noexcept;

  uint64_t count() const noexcept { return count_; }
  /// The duration that this part of all, 0 to 1, does not exceed, in milliseconds; 0 if there are none.
  double percentileMs(double part) const noexcept;
  double maxMs() const noexcept { return static_cast<double>(max_us_) * 1e-3; }

 private:
  static constexpr unsigned kPartBits = 5;                     ///< a power of two has 32 parts
  static constexpr uint64_t kMaxUs = (uint64_t{1} << 32) - 1;  ///< longer ones count as this
  static constexpr size_t kBuckets = (32 - kPartBits + 1) << kPartBits;
  static size_t bucketOf(uint64_t us) noexcept;
  static uint64_t lastOf(size_t bucket) noexcept;

  std::array<uint64_t, kBuckets> counts_{};
  uint64_t count_ = 0, max_us_ = 0;
};

}  // namespace lode::app
