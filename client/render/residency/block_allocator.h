#pragma once

#include <cstdint>
#include <map>
#include <optional>

namespace lode::render {

/// Hands out ranges of a buffer: best fit, lowest offset on ties, neighbours joined on release. Pure
/// bookkeeping. Not thread safe.
class BlockAllocator {
 public:
  static constexpr uint32_t kAlignment = 48;  ///< offsets and lengths are multiples of it: whole
                                              ///< vertices of 16 bytes and of 24

  /// @param capacity_bytes  rounded down to the alignment.
  explicit BlockAllocator(uint32_t capacity_bytes);

  /// @return the offset in bytes, or nothing if no free range is long enough. bytes > 0.
  std::optional<uint32_t> allocate(uint32_t bytes);
  /// @param offset, bytes  as given to and by allocate().
  void release(uint32_t offset, uint32_t bytes);

  uint32_t usedBytes() const noexcept { return used_bytes_; }
  bool empty() const noexcept { return used_bytes_ == 0; }
  static constexpr uint32_t roundUp(uint32_t bytes) noexcept {
    return (bytes + kAlignment - 1) / kAlignment * kAlignment;
  }

 private:
  std::map<uint32_t, uint32_t> free_;  ///< offset -> bytes
  uint32_t used_bytes_ = 0;
};

}  // namespace lode::render
