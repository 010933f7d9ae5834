#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <unordered_map>

namespace lode::serve {

/// Delays the answers to wrong tokens. The delay doubles with each wrong token of an address; an address is
/// forgotten when it has sent none for kForget. Answers that wait are bounded, and so are the addresses that
/// are remembered. While too many answers wait, an address that must wait is not heard at all. Must outlive
/// its waits. Thread safe.
class WrongTokens {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kLongestDelay{5000};
  static constexpr Clock::duration kForget = std::chrono::minutes(10);
  static constexpr size_t kMostAddresses =
      1024;                                   ///< another address replaces the one that was silent longest
  static constexpr size_t kMostWaiting = 64;  ///< answers that wait, of all addresses
  static constexpr uint32_t kMostWaitingPerAddress = 8;

  /// @param first_delay  delay of the answer to an address's first wrong token.
  explicit WrongTokens(Clock::duration first_delay) noexcept : first_delay_(first_delay) {}

  /// An answer that waits. The destructor makes room for another.
  class Wait {
   public:
    Wait(Wait&& other) noexcept;
    Wait& operator=(Wait&&) = delete;
    ~Wait();
    Clock::time_point until() const noexcept { return until_; }

   private:
    friend class WrongTokens;
    Wait(WrongTokens& of, uint64_t address, Clock::time_point until) noexcept
        : of_(&of), address_(address), until_(until) {}
    WrongTokens* of_;
    uint64_t address_;
    Clock::time_point until_;
  };

  /// Returns true if a token of the address must not be looked at now, right or wrong.
  /// @param address  see addressKey().
  bool blocks(uint64_t address, Clock::time_point now) const;
  /// Notes a wrong token. @return the wait before its answer, or nothing if too many answers wait.
  std::optional<Wait> add(uint64_t address, Clock::time_point now);

  size_t waiting() const;
  size_t addresses() const;

 private:
  struct Record {
    uint32_t wrong = 0, waiting = 0;
    Clock::time_point last;  ///< time of the last wrong token
  };
  Clock::duration delayOf(const Record& record) const noexcept;
  void leave(uint64_t address) noexcept;
  void makeRoom(Clock::time_point now);

  const Clock::duration first_delay_;
  mutable std::mutex mutex_;
  std::unordered_map<uint64_t, Record> records_;
  size_t waiting_ = 0;
};

}  // namespace lode::serve
