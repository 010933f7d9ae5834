#pragma once

#include <cstdint>

namespace lode::serve {

/// Raises the limit of open files of this process to what it may be.
/// @return how many it can have open now.
uint64_t raiseOpenFileLimit() noexcept;

/// A descriptor kept in hand: when there are no more, it is given up to take a connection and say why it must
/// go. Not thread safe.
class ReserveDescriptor {
 public:
  ReserveDescriptor() noexcept { keep(); }
  ~ReserveDescriptor() { giveUp(); }
  ReserveDescriptor(const ReserveDescriptor&) = delete;
  ReserveDescriptor& operator=(const ReserveDescriptor&) = delete;

  void giveUp() noexcept;
  void keep() noexcept;  ///< again, if there is one to be had

 private:
  int descriptor_ = -1;
};

}  // namespace lode::serve
