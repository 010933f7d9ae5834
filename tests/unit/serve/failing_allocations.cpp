#include "tests/unit/serve/failing_allocations.h"

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace {

std::atomic<bool> armed{false};
std::atomic<size_t> least_bytes{0}, most_bytes{0}, failures{0};
std::atomic<std::thread::id> watched;  ///< none: every thread
std::atomic<int64_t> to_go{0};

bool fails(size_t bytes) noexcept {
  if (!armed.load(std::memory_order_acquire)) return false;
  const std::thread::id thread = watched.load(std::memory_order_relaxed);
  bool chosen = bytes >= least_bytes && bytes <= most_bytes;
  if (thread != std::thread::id()) chosen = thread == std::this_thread::get_id() && to_go.fetch_sub(1) == 0;
  if (chosen) ++failures;
  return chosen;
}

void arm(std::thread::id thread, size_t least, size_t most, size_t nth = 0) {
  watched = thread;
  least_bytes = least;
  most_bytes = most;
  to_go = static_cast<int64_t>(nth);
  failures = 0;
  armed.store(true, std::memory_order_release);
}

}  // namespace

// What new and delete are made of.
// NOLINTBEGIN(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory)
void* operator new(size_t bytes) {
  void* const memory = fails(bytes) ? nullptr : std::malloc(bytes == 0 ? 1 : bytes);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
// NOLINTEND(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory)

namespace lode::serve::test {

FailingAllocations FailingAllocations::ofSize(size_t least, size_t most) {
  arm({}, least, most);
  return {};
}

FailingAllocations FailingAllocations::nthOf(std::thread::id thread, size_t nth) {
  arm(thread, 0, 0, nth);
  return {};
}

FailingAllocations::~FailingAllocations() { armed = false; }

size_t FailingAllocations::failed() const noexcept { return failures; }

}  // namespace lode::serve::test
