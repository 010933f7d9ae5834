#pragma once

#include <cstddef>

namespace lode::serve {

/// Blocks for small allocations after malloc has failed. Asio calls std::terminate() where it cannot allocate
/// the state of an operation. The program's operator new takes blocks from here (server/operator_new.cpp);
/// larger requests still throw std::bad_alloc. One object in a process; thread safe.
class MemoryReserve {
 public:
  static constexpr size_t kBlocks = 128, kBlockBytes = 8u << 10;

  MemoryReserve() noexcept { refill(); }
  ~MemoryReserve();
  MemoryReserve(const MemoryReserve&) = delete;
  MemoryReserve& operator=(const MemoryReserve&) = delete;

  /// Returns a block for std::free(), or null if `bytes` is larger, no block is left or no reserve exists.
  static void* take(size_t bytes) noexcept;

  /// Replaces the blocks that were taken. @return how many were missing.
  size_t refill() noexcept;
};

}  // namespace lode::serve
