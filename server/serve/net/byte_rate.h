#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace lode::serve {

/// Limits the bytes per second of one connection or of all connections. A sender calls take(), waits until
/// the returned time, sends, and returns unsent bytes with give(). take() serves senders in the order of
/// their calls, so that they share the rate fairly. Thread safe.
class ByteRate {
 public:
  using Clock = std::chrono::steady_clock;
  /// A sender loses no part of its rate if it calls take() late by at most this time.
  static constexpr std::chrono::milliseconds kGrace{20};

  /// @param bytes_per_second  limit, or 0 for no limit; senders then never wait.
  explicit ByteRate(uint64_t bytes_per_second) noexcept;

  bool limited() const noexcept { return ns_per_byte_ > 0; }
  /// Reserves bytes of the rate. @return the time from which the sender can send them.
  Clock::time_point take(uint64_t bytes, Clock::time_point now) noexcept;
  void give(uint64_t bytes) noexcept;

 private:
  int64_t lastingNs(uint64_t bytes) const noexcept {
    return static_cast<int64_t>(static_cast<double>(bytes) * ns_per_byte_);
  }

  double ns_per_byte_;
  /// Time from which the next bytes can be sent, in ns since the epoch of Clock.
  std::atomic<int64_t> next_ns_{0};
};

}  // namespace lode::serve
