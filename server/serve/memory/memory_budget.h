#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>

namespace lode::serve {

/// What a connection may hold as long as the budget has it at all, whatever others hold.
constexpr uint64_t kPoliteBytes = 64u << 10;
/// The last sixteenth of the budget is for those that hold no more than this.
constexpr uint64_t kModestBytes = 16u << 10;
/// A connection that holds more than kPoliteBytes may hold this part of what is left of three quarters: the
/// more the greedy have taken, the less each of them may take, and a quarter is the others'.
constexpr uint64_t kGreedyPart = 64;

/// Returns an eighth of the memory that this process may use (memoryLimitBytes()).
uint64_t defaultMemoryBudget(const std::filesystem::path& root = "/");

/// The memory that all connections of a server together may take, in bytes. Thread safe.
class MemoryBudget {
 public:
  explicit MemoryBudget(uint64_t limit_bytes) noexcept : limit_(limit_bytes) {}

  uint64_t limit() const noexcept { return limit_; }
  uint64_t used() const noexcept { return used_.load(std::memory_order_relaxed); }
  /// So much is used that it is time to look often.
  bool tight() const noexcept { return used() > limit_ / 16 * 12; }
  /// So little is left, or will be when those who leave() have gone, that connections must be closed, those
  /// that hold the most, until relieved(). It is less than what new ones are refused from, so that they are
  /// not kept out by who stays.
  bool pressed() const noexcept { return staying() > limit_ / 16 * 13; }
  bool relieved() const noexcept { return staying() <= limit_ / 16 * 12; }
  /// What a connection holds on the average, with what it costs by itself.
  uint64_t mean() const noexcept;

 private:
  friend class MemoryAccount;
  bool take(uint64_t bytes, uint64_t up_to) noexcept;
  uint64_t staying() const noexcept;

  uint64_t limit_;
  std::atomic<uint64_t> used_{0}, accounts_{0};
  std::atomic<uint64_t> leaving_{0};  ///< of used_
};

/// What one connection holds of the budget; all of it goes back at the end. Not thread safe.
class MemoryAccount {
 public:
  explicit MemoryAccount(MemoryBudget& budget) noexcept : budget_(&budget) {}
  MemoryAccount(MemoryAccount&& other) noexcept;
  MemoryAccount& operator=(MemoryAccount&&) = delete;
  ~MemoryAccount();

  /// What every connection costs, once. @return false: the server has no room for another.
  bool admit(uint64_t base_bytes) noexcept;
  /// @return false if the connection would hold too much for what is left; nothing was taken then.
  bool tryTake(uint64_t bytes) noexcept;
  /// For what must be, as a last word.
  void take(uint64_t bytes) noexcept;
  void give(uint64_t bytes) noexcept;
  /// The connection has been given up: what it holds comes back soon, and it gets no more. Once.
  void leave() noexcept;
  uint64_t held() const noexcept { return base_ + held_; }

 private:
  MemoryBudget* budget_;
  uint64_t base_ = 0, held_ = 0;
  bool leaving_ = false;
};

}  // namespace lode::serve
