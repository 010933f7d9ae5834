#pragma once

#include <cstdint>

namespace lode::ingest {

/// Default memory budget of a build: half of the machine's memory or of the control group's limit. Thread
/// safe.
uint64_t defaultMemoryBytes();

/// One per core.
unsigned defaultThreads() noexcept;

/// CPU time of this process so far, over all threads.
double cpuSeconds() noexcept;

/// Peak resident memory of this process.
uint64_t peakRssBytes() noexcept;

/// Limits the allocator's heaps with a small memory budget, so that threads reuse each other's freed memory.
void shareHeaps(uint64_t memory_bytes) noexcept;

/// Returns freed memory to the system; call it between stages.
void trimHeap() noexcept;

}  // namespace lode::ingest
