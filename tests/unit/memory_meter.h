#pragma once

#include <cstdint>

namespace lode::test {

/// Measures the memory that this thread allocates by operator new after construction. At most one object per
/// thread at a time.
class MemoryMeter {
 public:
  MemoryMeter();
  int64_t peakBytes() const noexcept;
};

}  // namespace lode::test
