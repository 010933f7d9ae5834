#include "server/serve/memory_reserve.h"

#include <array>
#include <chrono>
#include <cstdlib>
#include <mutex>

namespace lode::serve {

// NOLINTBEGIN(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory): new would ask the handler
namespace {

std::mutex mutex;
std::array<void*, MemoryReserve::kBlocks> blocks;  ///< behind the mutex, as what follows
size_t in_hand = 0;

bool aBlockIsThere() noexcept {
  void* const block = std::malloc(MemoryReserve::kBlockBytes);
  std::free(block);
  return block != nullptr;
}

/// operator new calls this until it finds what it wants, and does not say how much that is: who comes again
/// at once, and again, although a block is there wants more than one. A single time is no proof, since
/// another thread may have freed it only now.
class Insistence {
 public:
  /// @return whether this thread has come too often, to begin anew.
  bool grows() noexcept {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ > kAtOnce) times_ = 0;
    last_ = now;
    if (++times_ < kProof) return false;
    times_ = 0;
    return true;
  }

 private:
  static constexpr unsigned kProof = 3;
  static constexpr auto kAtOnce = std::chrono::microseconds(50);
  std::chrono::steady_clock::time_point last_;
  unsigned times_ = 0;
};

void letGo() {
  static thread_local Insistence insistence;
  if (aBlockIsThere()) {
    if (insistence.grows()) throw std::bad_alloc();
    return;
  }
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
