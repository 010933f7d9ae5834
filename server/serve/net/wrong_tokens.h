#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <unordered_map>

namespace lode::serve {

/// Delays the answers to wrong tokens. The delay doubles with each wrong token from an address; after kForget
/// without a wrong token, the address counts as new. The numbers of waiting answers and of remembered
/// addresses are limited. While too many answers wait, blocks() returns true for every address whose delay
/// has not passed. This object must outlive its Wait objects. Thread safe.
class WrongTokens {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kLongestDelay{5000};
  static constexpr Clock::duration kForget = std::chrono::minutes(10);
  /// Largest number of addresses; a further address replaces the address whose last wrong token is oldest.
  static constexpr size_t kMostAddresses = 1024;
  static constexpr size_t kMostWaiting = 64;  ///< largest number of waiting answers to all addresses
  static constexpr uint32_t kMostWaitingPerAddress = 8;

  /// @param first_delay  delay of the answer to an address's first wrong token.
  explicit WrongTokens(Clock::duration first_delay) noexcept : first_delay_(first_delay) {}

  /// A waiting answer. The destructor makes room for another waiting answer.
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

  /// Returns true if the caller must refuse every token of the address now, right or wrong.
  /// @param address  see addressKey().
  bool blocks(uint64_t address, Clock::time_point now) const;
  /// Notes a wrong token. @return the wait before the answer to the token, or nothing if too many answers
  /// wait.
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
