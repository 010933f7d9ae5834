#pragma once

#include <cstddef>

namespace lode::serve {

/// Memory in hand for the time when the system gives none, so that what needs a little goes on. Asio needs
/// that: where an operation does not get the memory to begin with, the process ends. The program's operator
/// new takes from it (server/operator_new.cpp), and who asks for more than a block is refused by
/// std::bad_alloc as if there were no reserve. One at a time in a process; thread safe.
class MemoryReserve {
 public:
  static constexpr size_t kBlocks = 128, kBlockBytes = 8u << 10;

  MemoryReserve() noexcept { refill(); }
  ~MemoryReserve();
  MemoryReserve(const MemoryReserve&) = delete;
  MemoryReserve& operator=(const MemoryReserve&) = delete;

  /// A block, for std::free(); null if it is too small, none is left or there is no reserve.
  static void* take(size_t bytes) noexcept;

  /// Has malloc give again what was taken. @return how many blocks were missing.
  size_t refill() noexcept;
};

}  // namespace lode::serve
