#include "server/serve/memory/memory_reserve.h"

#include <array>
#include <cstdlib>
#include <mutex>

namespace lode::serve {

// NOLINTBEGIN(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory): used by operator new
namespace {

std::mutex mutex;
/// Blocks of the reserve; the mutex guards them and in_hand.
std::array<void*, MemoryReserve::kBlocks> blocks;
size_t in_hand = 0;

}  // namespace

MemoryReserve::~MemoryReserve() {
  const std::lock_guard lock(mutex);
  while (in_hand > 0) std::free(blocks[--in_hand]);
}

void* MemoryReserve::take(size_t bytes) noexcept {
  const std::lock_guard lock(mutex);
  return bytes > kBlockBytes || in_hand == 0 ? nullptr : blocks[--in_hand];
}

size_t MemoryReserve::refill() noexcept {
  const std::lock_guard lock(mutex);
  const size_t missing = kBlocks - in_hand;
  while (in_hand < kBlocks) {
    void* const block = std::malloc(kBlockBytes);
    if (block == nullptr) break;
    blocks[in_hand++] = block;
  }
  return missing;
}
// NOLINTEND(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory)

}  // namespace lode::serve
