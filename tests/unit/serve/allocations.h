#pragma once

#include <cstddef>
#include <cstdint>
#include <thread>

/// What the tests of this program watch: operator new.
namespace lode::serve::test {

/// While it lives, chosen allocations find no memory but the MemoryReserve's. One at a time.
class FailingAllocations {
 public:
  /// All of so many bytes, both ends included, on any thread.
  static FailingAllocations ofSize(size_t least_bytes, size_t most_bytes);
  /// One alone, the nth from now (0: the next) on a thread.
  static FailingAllocations nthOf(std::thread::id thread, size_t nth);
  /// One alone, the nth from now on any thread but this one.
  static FailingAllocations nthOfOthers(size_t nth);
  ~FailingAllocations();
  FailingAllocations(const FailingAllocations&) = delete;
  FailingAllocations& operator=(const FailingAllocations&) = delete;

  /// How many have failed so far.
  size_t failed() const noexcept;

 private:
  FailingAllocations() = default;
};

/// Counts the allocations of all threads but the one that made it. One at a time.
class AllocationsOfOthers {
 public:
  AllocationsOfOthers();
  ~AllocationsOfOthers();
  AllocationsOfOthers(const AllocationsOfOthers&) = delete;
  AllocationsOfOthers& operator=(const AllocationsOfOthers&) = delete;

  uint64_t count() const noexcept;
};

}  // namespace lode::serve::test
