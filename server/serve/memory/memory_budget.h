#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>

namespace lode::serve {

/// A connection may hold this much if the budget has it left, regardless of other connections.
constexpr uint64_t kPoliteBytes = 64u << 10;
/// The last 1/16 of the budget is reserved for connections that hold at most this.
constexpr uint64_t kModestBytes = 16u << 10;
/// Above kPoliteBytes a connection may hold 1/64 of the unused part of the first 3/4: the more large
/// connections hold, the less each may grow, and 1/4 is left for the others.
constexpr uint64_t kLargeDivisor = 64;

/// Returns an eighth of the memory that this process may use (memoryLimitBytes()).
uint64_t defaultMemoryBudget(const std::filesystem::path& root = "/");

/// Budget in bytes of the memory of all connections of a server. Thread safe.
class MemoryBudget {
 public:
  explicit MemoryBudget(uint64_t limit_bytes) noexcept : limit_(limit_bytes) {}

  uint64_t limit() const noexcept { return limit_; }
  uint64_t used() const noexcept { return used_.load(std::memory_order_relaxed); }
  /// Above 12/16 of the budget: check often.
  bool tight() const noexcept { return used() > limit_ / 16 * 12; }
  /// Above 13/16 of the budget: close the largest connections until relieved(). Connections that are already
  /// closing do not count. New connections are admitted up to 14/16, so that closing makes room for them.
  bool pressed() const noexcept { return staying() > limit_ / 16 * 13; }
  bool relieved() const noexcept { return staying() <= limit_ / 16 * 12; }
  /// Average bytes that a connection holds, including its base cost.
  uint64_t mean() const noexcept;

 private:
  friend class MemoryAccount;
  bool take(uint64_t bytes, uint64_t up_to) noexcept;
  uint64_t staying() const noexcept;

  uint64_t limit_;
  std::atomic<uint64_t> used_{0}, accounts_{0};
  std::atomic<uint64_t> leaving_{0};  ///< part of used_ held by closing connections
};

/// Memory that one connection holds of the budget. The destructor returns it. Not thread safe.
class MemoryAccount {
 public:
  explicit MemoryAccount(MemoryBudget& budget) noexcept : budget_(&budget) {}
  MemoryAccount(MemoryAccount&& other) noexcept;
  MemoryAccount& operator=(MemoryAccount&&) = delete;
  ~MemoryAccount();

  /// Takes the base cost of a connection. @return false if the budget has no room for another connection.
  bool admit(uint64_t base_bytes) noexcept;
  /// Takes bytes. @return false, and takes nothing, if the connection would hold more than it may.
  bool tryTake(uint64_t bytes) noexcept;
  /// Takes bytes unconditionally, for example for the Error that closes the connection.
  void take(uint64_t bytes) noexcept;
  void give(uint64_t bytes) noexcept;
  /// Marks the connection as closing: it gets no more memory, and pressed() no longer counts it.
  void leave() noexcept;
  uint64_t held() const noexcept { return base_ + held_; }

 private:
  MemoryBudget* budget_;
  uint64_t base_ = 0, held_ = 0;
  bool leaving_ = false;
};

}  // namespace lode::serve
