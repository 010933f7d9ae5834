#include "client/render/residency/block_allocator.h"

#include <cassert>
#include <iterator>

namespace lode::render {

BlockAllocator::BlockAllocator(uint32_t capacity_bytes) {
  const uint32_t capacity = capacity_bytes / kAlignment * kAlignment;
  if (capacity > 0) free_.emplace(0, capacity);
}

std::optional<uint32_t> BlockAllocator::allocate(uint32_t bytes) {
  const uint32_t wanted = roundUp(bytes);
  auto best = free_.end();
  for (auto it = free_.begin(); it != free_.end(); ++it) {
    if (it->second >= wanted && (best == free_.end() || it->second < best->second)) best = it;
  }
  if (best == free_.end()) return std::nullopt;
  const auto [offset, length] = *best;
  free_.erase(best);
  if (length > wanted) free_.emplace(offset + wanted, length - wanted);
  used_bytes_ += wanted;
  return offset;
}

void BlockAllocator::release(uint32_t offset, uint32_t bytes) {
  uint32_t length = roundUp(bytes);
  assert(used_bytes_ >= length);
  used_bytes_ -= length;
  auto next = free_.lower_bound(offset);
  if (next != free_.end() && offset + length == next->first) {
    length += next->second;
    next = free_.erase(next);
  }
  if (next != free_.begin()) {
    const auto before = std::prev(next);
    assert(before->first + before->second <= offset);
    if (before->first + before->second == offset) {
      before->second += length;
      return;
    }
  }
  free_.emplace(offset, length);
}

}  // namespace lode::render
