#pragma once

#include <cstddef>
#include <new>

namespace lode::serve {

/// Memory in hand for the time when the system gives none: operator new lets go of a block of it at a time,
/// so that what needs a little goes on. Asio needs that: where an operation does not get the memory to begin
/// with, the process ends. Who asks for more than a block is refused by std::bad_alloc, as if there were no
/// reserve, and takes a block of it at most. One at a time in a process; thread safe.
class MemoryReserve {
 public:
  static constexpr size_t kBlocks = 128, kBlockBytes = 8u << 10;

  MemoryReserve() noexcept;
  ~MemoryReserve();
  MemoryReserve(const MemoryReserve&) = delete;
  MemoryReserve& operator=(const MemoryReserve&) = delete;

  /// Takes again what was let go, if the system gives it. @return how many blocks were missing.
  size_t refill() noexcept;

 private:
  std::new_handler before_;
};

}  // namespace lode::serve
