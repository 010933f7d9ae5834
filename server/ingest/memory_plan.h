#pragma once

#include <cstdint>

#include "common/mesh.h"

namespace lode::ingest {

/// How a build divides its memory (I7). What stages need was measured with samples of 2 and 10 million
/// triangles, and is proportional to the triangles of a node.
struct MemoryPlan {
  uint64_t sort_bytes = 0;     ///< for what a sort, or a batch of faces with their vertices, holds
  unsigned threads = 1;        ///< that simplify: as many as asked for, fewer where their nodes would not fit
  uint64_t minimum_bytes = 0;  ///< below, not even one thread's nodes fit; small models need less
};

MemoryPlan planMemory(uint64_t memory_bytes, unsigned threads, uint32_t triangles_per_node) noexcept;

/// The peak to expect of a build by a plan.
uint64_t expectedPeakBytes(const MemoryPlan& plan, uint64_t vertices, uint64_t triangles, AttributeSet file,
                           uint32_t triangles_per_node) noexcept;

}  // namespace lode::ingest
