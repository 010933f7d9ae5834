#include "server/serve/memory/memory_reserve.h"

#include <array>
#include <cstdlib>
#include <mutex>

namespace lode::serve {

// NOLINTBEGIN(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory): used by operator new
namespace {

std::mutex mutex;
/// Blocks of the reserve; the mutex guards all variables.
std::array<void*, MemoryReserve::kBlocks> blocks;
size_t in_hand = 0, blocks_taken = 0;
bool exists = false;
thread_local bool abstains = false;

}  // namespace

MemoryReserve::Abstention::Abstention() noexcept { abstains = true; }

MemoryReserve::Abstention::~Abstention() { abstains = false; }

MemoryReserve::MemoryReserve() noexcept {
  exists = true;
  refill();
}

MemoryReserve::~MemoryReserve() {
  const std::lock_guard lock(mutex);
  exists = false;
  while (in_hand > 0) std::free(blocks[--in_hand]);
}

void* MemoryReserve::take(size_t bytes) noexcept {
  if (abstains) return nullptr;
  const std::lock_guard lock(mutex);
  if (bytes > kBlockBytes || in_hand == 0) return nullptr;
  ++blocks_taken;
  return blocks[--in_hand];
}

bool MemoryReserve::refill() noexcept {
  const std::lock_guard lock(mutex);
  while (exists && in_hand < kBlocks) {
    void* const block = std::malloc(kBlockBytes);
    if (block == nullptr) return false;
    blocks[in_hand++] = block;
  }
  return true;
}

size_t MemoryReserve::taken() noexcept {
  const std::lock_guard lock(mutex);
  return blocks_taken;
}
// NOLINTEND(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory)

}  // namespace lode::serve
