#pragma once

#include <cstddef>

namespace lode::serve {

/// Reserve of memory blocks that serve small allocations after malloc has failed. Without the reserve, the
/// process could end, because asio calls std::terminate() if the state of an operation cannot be allocated.
/// The program's operator new (server/operator_new.cpp) uses these blocks. Allocations larger than a block
/// still throw std::bad_alloc. The acceptor refuses connections while a block is missing, because each new
/// connection needs several blocks. A process can have only one reserve. Thread safe.
class MemoryReserve {
 public:
  static constexpr size_t kBlocks = 1024, kBlockBytes = 1u << 10;

  MemoryReserve() noexcept;
  ~MemoryReserve();
  MemoryReserve(const MemoryReserve&) = delete;
  MemoryReserve& operator=(const MemoryReserve&) = delete;

  /// While this object exists, its thread cannot use the reserve. For work that is allowed to fail and could
  /// use up the reserve.
  class Abstention {
   public:
    Abstention() noexcept;
    ~Abstention();
    Abstention(const Abstention&) = delete;
    Abstention& operator=(const Abstention&) = delete;
  };

  /// Returns a block, which the caller frees with std::free(). Returns null if `bytes` exceeds the size of a
  /// block, no block is left, no reserve exists, or the thread has an Abstention.
  static void* take(size_t bytes) noexcept;

  /// Replaces the blocks that take() returned.
  /// @return false if the system still refuses memory for a block. Without a reserve, returns true.
  static bool refill() noexcept;

  /// Returns the number of blocks that take() has returned since the process began.
  static size_t taken() noexcept;
};

}  // namespace lode::serve
