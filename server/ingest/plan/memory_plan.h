#pragma once

#include <cstdint>
#include <string>

#include "common/mesh.h"

namespace lode::ingest {

/// How a build divides its memory (I7). What stages need was measured with samples of 2 and 10 million
/// triangles, and is proportional to the triangles of a node.
struct MemoryPlan {
  uint64_t sort_bytes = 0;  ///< for what a sort, or a batch of faces with their vertices, holds
  unsigned threads = 1;     ///< as many as asked for, fewer where the nodes that they simplify would not fit
  /// For one texture image: its file, its texels and what decoding and halving them takes. All but what the
  /// program and one encoder of tiles take; of a small budget, half.
  uint64_t image_bytes = 0;
  uint64_t node_bytes = 0;     ///< for the nodes that are simplified, and the records of all
  uint64_t minimum_bytes = 0;  ///< below, not even one thread's nodes fit; small models need less
};

MemoryPlan planMemory(uint64_t memory_bytes, unsigned threads, uint32_t triangles_per_node) noexcept;

constexpr uint64_t kNodeRecordBytes = 96;  ///< of each node of a tree, while it is simplified

/// What a node takes while it is reduced and measured. @param triangles  of its input.
constexpr uint64_t memoryOfNode(uint64_t triangles) noexcept {
  constexpr uint64_t kTriangleBytes = 1024;  ///< quadrics, queue, LODs, the walk; with a tree to measure
  return triangles * kTriangleBytes;
}

/// Why a build may use more than a budget, with the least that it keeps, for warnings; empty if it keeps it.
/// @param is_one_node  the whole model fits one node: it takes little beside the program.
std::string smallBudgetInWords(uint64_t memory_bytes, uint32_t triangles_per_node, bool is_one_node);
/// "--memory is less than N, which WHAT TAKES; ...".
std::string budgetBelowInWords(uint64_t least_bytes, const std::string& what_takes);

/// The budget with which a node of more triangles than a budget can be built, with nothing beside it.
uint64_t memoryForLargeNode(uint64_t triangles, AttributeSet attributes) noexcept;

/// The least budget that leaves an image so many bytes.
uint64_t budgetForImage(uint64_t image_bytes) noexcept;

/// How many threads may encode the tiles of an image that takes so many bytes: as many as asked for, fewer
/// where their encoders would not fit beside it.
unsigned encoderThreads(uint64_t memory_bytes, uint64_t image_bytes, unsigned threads) noexcept;

/// The peak to expect of a build by a plan.
/// @param texture_bytes  that the stage "textures" takes beside the program.
uint64_t expectedPeakBytes(const MemoryPlan& plan, uint64_t vertices, uint64_t triangles, AttributeSet file,
                           uint32_t triangles_per_node, uint64_t texture_bytes) noexcept;

}  // namespace lode::ingest
