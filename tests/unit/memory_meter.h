#pragma once

#include <cstdint>

namespace lode::test {

/// Watches what this thread takes from the heap by operator new, from construction on. One at a time a
/// thread.
class MemoryMeter {
 public:
  MemoryMeter();
  int64_t peakBytes() const noexcept;
};

}  // namespace lode::test
