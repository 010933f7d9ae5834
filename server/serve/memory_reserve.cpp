#include "server/serve/memory_reserve.h"

#include <array>
#include <cstdlib>
#include <mutex>

namespace lode::serve {

// NOLINTBEGIN(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory): new would ask the handler
namespace {

std::mutex mutex;
std::array<void*, MemoryReserve::kBlocks> blocks;  ///< behind the mutex, as what follows
size_t in_hand = 0;

void letGo() {
  const std::lock_guard lock(mutex);
  if (in_hand == 0) throw std::bad_alloc();
  std::free(blocks[--in_hand]);
}

}  // namespace

MemoryReserve::MemoryReserve() noexcept : before_(std::set_new_handler(letGo)) { refill(); }

MemoryReserve::~MemoryReserve() {
  std::set_new_handler(before_);
  const std::lock_guard lock(mutex);
  while (in_hand > 0) std::free(blocks[--in_hand]);
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
