#pragma once

#include <cstdint>

namespace lode::ingest {

/// Half of the machine's memory, or of what a control group leaves this process: what a build uses at most
/// unless it is told otherwise. Thread safe.
uint64_t defaultMemoryBytes();

/// One a core.
unsigned defaultThreads() noexcept;

/// CPU time of this process so far, all threads.
double cpuSeconds() noexcept;

/// The most resident memory that this process has had.
uint64_t peakRssBytes() noexcept;

/// Lets threads share the allocator's heaps where there is little memory: what one has freed is otherwise
/// kept for its own thread.
void shareHeaps(uint64_t memory_bytes) noexcept;

/// Gives freed memory back to the system, which an allocator may keep for long: for between stages.
void trimHeap() noexcept;

}  // namespace lode::ingest
