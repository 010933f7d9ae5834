#include "server/ingest/plan/machine.h"

#include <algorithm>
#include <cstdlib>  // defines __GLIBC__
#include <ctime>
#include <thread>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <sys/resource.h>

#include "common/memory_limit.h"

namespace lode::ingest {
namespace {

/// Bytes of memory budget per allocator heap. If each of eight threads had its own heap, a small build would
/// use 50 % more memory.
constexpr uint64_t kMemoryForEachHeap = 64 << 20;
constexpr uint64_t kMostHeaps = 256;

}  // namespace

uint64_t defaultMemoryBytes() { return memoryLimitBytes() / 2; }

unsigned defaultThreads() noexcept { return std::max(1u, std::thread::hardware_concurrency()); }

double cpuSeconds() noexcept {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

uint64_t peakRssBytes() noexcept {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<uint64_t>(usage.ru_maxrss) * 1024;
}

void shareHeaps(uint64_t memory_bytes) noexcept {
#if defined(__GLIBC__)
  mallopt(M_ARENA_MAX,
          static_cast<int>(std::clamp<uint64_t>(memory_bytes / kMemoryForEachHeap, 1, kMostHeaps)));
#endif
}

void trimHeap() noexcept {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

}  // namespace lode::ingest
