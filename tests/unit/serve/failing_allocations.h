#pragma once

#include <cstddef>
#include <thread>

namespace lode::serve::test {

/// While it lives, chosen allocations by operator new fail with std::bad_alloc. One at a time.
class FailingAllocations {
 public:
  /// All of so many bytes, both ends included, on any thread.
  static FailingAllocations ofSize(size_t least_bytes, size_t most_bytes);
  /// One alone, the nth from now (0: the next) on a thread.
  static FailingAllocations nthOf(std::thread::id thread, size_t nth);
  ~FailingAllocations();
  FailingAllocations(const FailingAllocations&) = delete;
  FailingAllocations& operator=(const FailingAllocations&) = delete;

  /// How many have failed so far.
  size_t failed() const noexcept;

 private:
  FailingAllocations() = default;
};

}  // namespace lode::serve::test
