#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace lode::serve {

/// So many bytes a second, of one connection or of all together. Who wants to send takes a turn, waits for
/// its time, and gives back what it did not need. Turns come in the order in which they were taken, so that
/// of many that send each has its share. Thread safe.
class ByteRate {
 public:
  using Clock = std::chrono::steady_clock;
  /// Who is late for a turn by no more than this loses nothing by it.
  static constexpr std::chrono::milliseconds kGrace{20};

  /// @param bytes_per_second  0: without a limit; every turn is now.
  explicit ByteRate(uint64_t bytes_per_second) noexcept;

  bool limited() const noexcept { return ns_per_byte_ > 0; }
  /// @return when so many bytes may be sent.
  Clock::time_point take(uint64_t bytes, Clock::time_point now) noexcept;
  void give(uint64_t bytes) noexcept;

 private:
  int64_t lastingNs(uint64_t bytes) const noexcept {
    return static_cast<int64_t>(static_cast<double>(bytes) * ns_per_byte_);
  }

  double ns_per_byte_;
  std::atomic<int64_t> next_ns_{0};  ///< when the next turn begins, by the clock
};

}  // namespace lode::serve
