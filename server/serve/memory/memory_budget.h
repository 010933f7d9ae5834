#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>

namespace lode::serve {

/// Memory that every connection can use while the budget has room, however much other connections use.
constexpr uint64_t kPoliteBytes = 64u << 10;
/// Largest memory of a small connection. The last 1/16 of the budget is reserved for small connections.
constexpr uint64_t kModestBytes = 16u << 10;
/// Divisor that limits a connection above kPoliteBytes. Such a connection can use at most 1/64 of what is
/// still free of the first 3/4 of the budget, so its limit shrinks as all connections use more memory. The
/// last 1/4 of the budget is left to connections below kPoliteBytes.
constexpr uint64_t kLargeDivisor = 64;

/// Returns an eighth of the memory that this process can use (memoryLimitBytes()).
uint64_t defaultMemoryBudget(const std::filesystem::path& root = "/");

/// Limits the memory that all connections of a server use together. Thread safe.
class MemoryBudget {
 public:
  explicit MemoryBudget(uint64_t limit_bytes) noexcept : limit_(limit_bytes) {}

  uint64_t limit() const noexcept { return limit_; }
  uint64_t used() const noexcept { return used_.load(std::memory_order_relaxed); }
  /// Returns true if more than 12/16 of the budget are used. The server then checks the budget more often.
  bool tight() const noexcept { return used() > limit_ / 16 * 12; }
  /// Returns true if open connections use more than 13/16 of the budget. The server then closes the largest
  /// connections until relieved() returns true. Connections that are closing do not count. The server
  /// refuses new connections only above 14/16 of the budget, so it can admit some while it closes large ones.
  bool pressed() const noexcept { return staying() > limit_ / 16 * 13; }
  bool relieved() const noexcept { return staying() <= limit_ / 16 * 12; }
  /// Returns the average memory of a connection in bytes, including its base cost.
  uint64_t mean() const noexcept;

 private:
  friend class MemoryAccount;
  bool take(uint64_t bytes, uint64_t up_to) noexcept;
  uint64_t staying() const noexcept;

  uint64_t limit_;
  std::atomic<uint64_t> used_{0}, accounts_{0};
  std::atomic<uint64_t> leaving_{0};  ///< memory of closing connections, which used_ includes
};

/// Memory that one connection uses, charged to the budget. The destructor returns the memory to the budget.
/// Not thread safe.
class MemoryAccount {
 public:
  explicit MemoryAccount(MemoryBudget& budget) noexcept : budget_(&budget) {}
  MemoryAccount(MemoryAccount&& other) noexcept;
  MemoryAccount& operator=(MemoryAccount&&) = delete;
  ~MemoryAccount();

  /// Charges the base cost of a connection. @return false if the budget has no room for another connection.
  bool admit(uint64_t base_bytes) noexcept;
  /// Charges bytes if the connection stays within its limits. @return false, without a charge, if the bytes
  /// would exceed a limit.
  bool tryTake(uint64_t bytes) noexcept;
  /// Charges bytes without checking the limits, for example for the Error that closes the connection.
  void take(uint64_t bytes) noexcept;
  void give(uint64_t bytes) noexcept;
  /// Marks the connection as closing. The connection gets no more memory, and pressed() no longer counts its
  /// memory.
  void leave() noexcept;
  uint64_t held() const noexcept { return base_ + held_; }

 private:
  MemoryBudget* budget_;
  uint64_t base_ = 0, held_ = 0;
  bool leaving_ = false;
};

}  // namespace lode::serve
