#pragma once

#include <cstddef>
#include <cstdint>
#include <thread>

/// This program's operator new counts allocations and can fail.
namespace lode::serve::test {

/// During this object's lifetime, selected allocations fail unless the MemoryReserve serves them. At most one
/// object at a time.
class FailingAllocations {
 public:
  /// Fails all allocations of least_bytes to most_bytes, on all threads.
  static FailingAllocations ofSize(size_t least_bytes, size_t most_bytes);
  /// Fails the nth allocation from now (0: the next) on a thread.
  static FailingAllocations nthOf(std::thread::id thread, size_t nth);
  /// Fails the nth allocation from now on all threads but the calling one.
  static FailingAllocations nthOfOthers(size_t nth);
  ~FailingAllocations();
  FailingAllocations(const FailingAllocations&) = delete;
  FailingAllocations& operator=(const FailingAllocations&) = delete;

  /// Number of allocations that have failed.
  size_t failed() const noexcept;

 private:
  FailingAllocations() = default;
};

/// Simulates a system without memory: forbids new mappings and allocates all that malloc still has.
void takeAllMemory();

/// Counts the allocations of all threads except the one that constructed it. One object at a time.
class AllocationsOfOthers {
 public:
  AllocationsOfOthers();
  ~AllocationsOfOthers();
  AllocationsOfOthers(const AllocationsOfOthers&) = delete;
  AllocationsOfOthers& operator=(const AllocationsOfOthers&) = delete;

  uint64_t count() const noexcept;
};

}  // namespace lode::serve::test
