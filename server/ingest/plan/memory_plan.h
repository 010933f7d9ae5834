#pragma once

#include <cstdint>
#include <string>

#include "common/mesh.h"

namespace lode::ingest {

/// Division of a build's memory (I7 in docs/architecture.md). The needs of stages are measured and
/// proportional to the triangles per node.
struct MemoryPlan {
  uint64_t sort_bytes = 0;  ///< for a sort, or for a batch of faces with their vertices
  unsigned threads = 1;     ///< as requested; fewer if the nodes that they simplify would not fit
  /// For one texture image: file, texels and buffers to decode and halve them. All memory except that of the
  /// program and one tile encoder; at least half of it.
  uint64_t image_bytes = 0;
  uint64_t node_bytes = 0;     ///< for nodes being simplified and the records of all nodes
  uint64_t minimum_bytes = 0;  ///< needed for one thread's nodes; small models need less
};

MemoryPlan planMemory(uint64_t memory_bytes, unsigned threads, uint32_t triangles_per_node) noexcept;

constexpr uint64_t kNodeRecordBytes = 96;  ///< per node of a tree that is being simplified

/// Memory to simplify and measure a node. @param triangles  of its input mesh.
constexpr uint64_t memoryOfNode(uint64_t triangles) noexcept {
  constexpr uint64_t kTriangleBytes = 1024;  ///< quadrics, queue, LODs and the search tree for errors
  return triangles * kTriangleBytes;
}

/// Returns a warning if a build may exceed the memory budget, with the least budget that suffices; empty if
/// it does not. @param is_one_node  the whole model fits in one node, which needs little memory.
std::string smallBudgetInWords(uint64_t memory_bytes, uint32_t triangles_per_node, bool is_one_node);
/// Returns "--memory is less than the N needed for PURPOSE; ...".
std::string budgetBelowInWords(uint64_t least_bytes, const std::string& purpose);

/// Budget needed to build one node whose triangles exceed the node capacity, alone.
uint64_t memoryForLargeNode(uint64_t triangles, AttributeSet attributes) noexcept;

/// Least memory budget of which an image may use `image_bytes`.
uint64_t budgetForImage(uint64_t image_bytes) noexcept;

/// Number of threads that may encode tiles of an image that takes `image_bytes`: as requested, fewer if their
/// encoders would not fit beside it.
unsigned encoderThreads(uint64_t memory_bytes, uint64_t image_bytes, unsigned threads) noexcept;

/// Forecasts the peak memory of a build. @param texture_bytes  memory of the stage "textures", without the
/// program's.
uint64_t expectedPeakBytes(const MemoryPlan& plan, uint64_t vertices, uint64_t triangles, AttributeSet file,
                           uint32_t triangles_per_node, uint64_t texture_bytes) noexcept;

}  // namespace lode::ingest
