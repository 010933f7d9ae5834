#include "tests/unit/serve/allocations.h"

#include <atomic>
#include <cstdlib>
#include <new>

#include <sys/resource.h>

#include "server/serve/memory/memory_reserve.h"

namespace {

/// Selects the allocations that fail.
enum class Chosen { kNone, kBySize, kNthOfThread, kNthOfOthers };

std::atomic<Chosen> chosen{Chosen::kNone};
std::atomic<size_t> least_bytes{0}, most_bytes{0}, failures{0};
std::atomic<std::thread::id> watched;
std::atomic<int64_t> to_go{0};

std::atomic<std::thread::id> counted_beside;  ///< default id: count nothing
std::atomic<uint64_t> counted{0};

bool isChosen(size_t bytes) noexcept {
  const bool by_thread = std::this_thread::get_id() == watched.load(std::memory_order_relaxed);
  switch (chosen.load(std::memory_order_acquire)) {
    case Chosen::kBySize:
      return bytes >= least_bytes && bytes <= most_bytes;
    case Chosen::kNthOfThread:
      return by_thread && to_go.fetch_sub(1) == 0;
    case Chosen::kNthOfOthers:
      return !by_thread && to_go.fetch_sub(1) == 0;
    case Chosen::kNone:
      break;
  }
  return false;
}

/// Counts the allocation. @return true if it must fail.
bool watch(size_t bytes) noexcept {
  const std::thread::id beside = counted_beside.load(std::memory_order_relaxed);
  if (beside != std::thread::id() && beside != std::this_thread::get_id()) ++counted;
  const bool fails = isChosen(bytes);
  if (fails) ++failures;
  return fails;
}

void arm(Chosen which, std::thread::id thread, size_t nth, size_t least = 0, size_t most = 0) {
  watched = thread;
  to_go = static_cast<int64_t>(nth);
  least_bytes = least;
  most_bytes = most;
  failures = 0;
  chosen.store(which, std::memory_order_release);
}

}  // namespace

// Mirrors server/operator_new.cpp.
// NOLINTBEGIN(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory)
void* operator new(size_t bytes, const std::nothrow_t&) noexcept {
  void* const memory = watch(bytes) ? nullptr : std::malloc(bytes == 0 ? 1 : bytes);
  return memory != nullptr ? memory : lode::serve::MemoryReserve::take(bytes);
}
void* operator new(size_t bytes) {
  void* const memory = ::operator new(bytes, std::nothrow);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
// NOLINTEND(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory)

namespace lode::serve::test {

FailingAllocations FailingAllocations::ofSize(size_t least, size_t most) {
  arm(Chosen::kBySize, {}, 0, least, most);
  return {};
}

FailingAllocations FailingAllocations::nthOf(std::thread::id thread, size_t nth) {
  arm(Chosen::kNthOfThread, thread, nth);
  return {};
}

FailingAllocations FailingAllocations::nthOfOthers(size_t nth) {
  arm(Chosen::kNthOfOthers, std::this_thread::get_id(), nth);
  return {};
}

void takeAllMemory() {
  const rlimit none{0, 0};
  setrlimit(RLIMIT_AS, &none);
  setrlimit(RLIMIT_DATA, &none);
  for (size_t bytes = 1u << 20; bytes >= 16; bytes /= 2)
    while (std::malloc(bytes) != nullptr) {  // NOLINT(cppcoreguidelines-no-malloc)
    }
}

FailingAllocations::~FailingAllocations() { chosen = Chosen::kNone; }

size_t FailingAllocations::failed() const noexcept { return failures; }

AllocationsOfOthers::AllocationsOfOthers() {
  counted = 0;
  counted_beside = std::this_thread::get_id();
}

AllocationsOfOthers::~AllocationsOfOthers() { counted_beside = std::thread::id(); }

uint64_t AllocationsOfOthers::count() const noexcept { return counted; }

}  // namespace lode::serve::test
