#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace lode {

/// Computes checksum() of bytes that arrive in pieces. Not thread safe.
class RunningChecksum {
 public:
  RunningChecksum();
  ~RunningChecksum();
  RunningChecksum(RunningChecksum&&) noexcept;
  RunningChecksum& operator=(RunningChecksum&&) noexcept;

  void add(std::span<const std::byte> bytes) noexcept;
  /// Returns the checksum of all bytes added so far.
  uint64_t value() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lode
