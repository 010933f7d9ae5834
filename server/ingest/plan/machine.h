#pragma once

#include <cstdint>

namespace lode::ingest {

/// Returns the default memory budget of a build: half of the machine's memory or half of the control group's
/// limit, whichever is smaller. Thread safe.
uint64_t defaultMemoryBytes();

/// Returns the default number of threads of a build: one per core.
unsigned defaultThreads() noexcept;

/// Returns the CPU time that all threads of this process have used so far.
double cpuSeconds() noexcept;

/// Returns the peak resident memory of this process.
uint64_t peakRssBytes() noexcept;

/// Limits the number of allocator heaps if the memory budget is small, so that threads reuse memory that
/// other threads have freed.
void shareHeaps(uint64_t memory_bytes) noexcept;

/// Returns freed memory to the system. A build calls this function between stages.
void trimHeap() noexcept;

}  // namespace lode::ingest
