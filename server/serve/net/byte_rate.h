#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace lode::serve {

/// Limits the bytes a second of one connection or of all connections. A sender takes a turn, waits until its
/// time and gives back the bytes that it did not send. Turns come in the order in which they were taken,
/// which shares the rate fairly. Thread safe.
class ByteRate {
 public:
  using Clock = std::chrono::steady_clock;
  /// A sender that is late by up to this much loses none of its rate.
  static constexpr std::chrono::milliseconds kGrace{20};

  /// @param bytes_per_second  0: no limit; every turn is now.
  explicit ByteRate(uint64_t bytes_per_second) noexcept;

  bool limited() const noexcept { return ns_per_byte_ > 0; }
  /// @return the time at which this many bytes may be sent.
  Clock::time_point take(uint64_t bytes, Clock::time_point now) noexcept;
  void give(uint64_t bytes) noexcept;

 private:
  int64_t lastingNs(uint64_t bytes) const noexcept {
    return static_cast<int64_t>(static_cast<double>(bytes) * ns_per_byte_);
  }

  double ns_per_byte_;
  std::atomic<int64_t> next_ns_{0};  ///< start of the next turn, time since the epoch of Clock
};

}  // namespace lode::serve
