#include "client/loadtest/latency_histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace lode::app {

size_t LatencyHistogram::bucketOf(uint64_t us) noexcept {
  const unsigned width = static_cast<unsigned>(std::bit_width(us));
  if (width <= kPartBits + 1) return us;
  const unsigned shift = width - kPartBits - 1;
  return (size_t{shift} << kPartBits) + (us >> shift);
}

uint64_t LatencyHistogram::lastOf(size_t bucket) noexcept {
  if (bucket < size_t{2} << kPartBits) return bucket;
  const size_t shift = (bucket >> kPartBits) - 1;
  const uint64_t first = uint64_t{bucket - (shift << kPartBits)} << shift;
  return first + (uint64_t{1} << shift) - 1;
}

void LatencyHistogram::add(std::chrono::nanoseconds duration) noexcept {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(duration).count();
  const uint64_t counted = std::min<uint64_t>(us > 0 ? static_cast<uint64_t>(us) : 0, kMaxUs);
  ++counts_[bucketOf(counted)];
  ++count_;
  max_us_ = std::max(max_us_, counted);
}

void LatencyHistogram::add(const LatencyHistogram& other) noexcept {
  for (size_t i = 0; i < kBuckets; ++i) counts_[i] += other.counts_[i];
  count_ += other.count_;
  max_us_ = std::max(max_us_, other.max_us_);
}

LatencyHistogram LatencyHistogram::since(const LatencyHistogram& earlier) const noexcept {
  LatencyHistogram added = *this;
  for (size_t i = 0; i < kBuckets; ++i) added.counts_[i] -= earlier.counts_[i];
  added.count_ -= earlier.count_;
  return added;
}

double LatencyHistogram::percentileMs(double part) const noexcept {
  const auto rank = static_cast<uint64_t>(std::ceil(part * static_cast<double>(count_)));
  uint64_t seen = 0;
  for (size_t i = 0; i < kBuckets; ++i) {
    seen += counts_[i];
    if (seen > 0 && seen >= rank) return static_cast<double>(std::min(lastOf(i), max_us_)) * 1e-3;
  }
  return 0;
}

}  // namespace lode::app
