#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace lode::serve {

/// A number that one thread adds to and any thread reads: no lock, no locked instruction.
class Counter {
 public:
  void add(uint64_t more = 1) noexcept {
    value_.store(value_.load(std::memory_order_relaxed) + more, std::memory_order_relaxed);
  }
  uint64_t read() const noexcept { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<uint64_t> value_{0};
};

/// Upper ends of a latency's buckets, seconds; one more holds what is beyond.
constexpr std::array kLatencyBoundsSeconds{0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02,
                                           0.05,   0.1,    0.2,    0.5,   1.0,   2.0,   5.0,  10.0};

/// Durations, counted by bucket. One thread adds, any reads.
class LatencyCounter {
 public:
  static constexpr size_t kBuckets = kLatencyBoundsSeconds.size() + 1;

  void add(std::chrono::nanoseconds duration) noexcept {
    const double seconds = std::chrono::duration<double>(duration).count();
    size_t bucket = 0;
    while (bucket < kLatencyBoundsSeconds.size() && seconds > kLatencyBoundsSeconds[bucket]) ++bucket;
    buckets_[bucket].add();
    sum_ns_.add(duration.count() > 0 ? static_cast<uint64_t>(duration.count()) : 0);
  }
  uint64_t bucket(size_t number) const noexcept { return buckets_[number].read(); }
  uint64_t sumNs() const noexcept { return sum_ns_.read(); }

 private:
  std::array<Counter, kBuckets> buckets_;
  Counter sum_ns_;
};

}  // namespace lode::serve
