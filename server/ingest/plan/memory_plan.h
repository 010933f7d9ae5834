#pragma once

#include <cstdint>
#include <string>

#include "common/mesh.h"

namespace lode::ingest {

/// Division of a build's memory (I7 in docs/architecture.md). Simplification needs memory in proportion to
/// the node capacity (--triangles-per-node); memory_plan.cpp has the measured factors.
struct MemoryPlan {
  uint64_t sort_bytes = 0;  ///< memory for one sort, or for dereferencing batches of faces
  /// Number of threads: as requested, or fewer if the nodes that they simplify would not fit.
  unsigned threads = 1;
  /// Memory for one texture image: its file, its texels, and the buffers to decode and halve the texels. This
  /// is half of the budget, or the budget without the program and one tile encoder, whichever is more.
  uint64_t image_bytes = 0;
  uint64_t node_bytes = 0;  ///< memory for nodes being simplified and for the records of all nodes
  /// Smallest budget with which a single thread can build nodes. Small models need less.
  uint64_t minimum_bytes = 0;
};

/// Divides the memory of a build. @param memory_bytes  memory budget of the build (--memory). @param threads
/// requested number of threads.
MemoryPlan planMemory(uint64_t memory_bytes, unsigned threads, uint32_t triangles_per_node) noexcept;

constexpr uint64_t kNodeRecordBytes = 128;  ///< memory per node of a tree that is being simplified

/// Returns the memory that it takes to simplify and measure a node. @param triangles  number of triangles in
/// the mesh from which the node's LODs are made.
constexpr uint64_t memoryOfNode(uint64_t triangles) noexcept {
  /// Memory per triangle for quadrics, the queue, LODs and the tree that measures errors.
  constexpr uint64_t kTriangleBytes = 1024;
  return triangles * kTriangleBytes;
}

/// Returns a warning if a build could exceed `memory_bytes`, else an empty string. The warning names the
/// smallest budget that suffices. @param is_one_node  true if the whole model fits in one node, which needs
/// little memory.
std::string smallBudgetInWords(uint64_t memory_bytes, uint32_t triangles_per_node, bool is_one_node);
/// Returns "--memory is less than the N needed for PURPOSE; the build may use more".
std::string budgetBelowInWords(uint64_t least_bytes, const std::string& purpose);

/// Returns the memory budget that suffices to build a node with more triangles than the node capacity if no
/// other node is built at the same time.
uint64_t memoryForLargeNode(uint64_t triangles, AttributeSet attributes) noexcept;

/// Returns the smallest memory budget that leaves `image_bytes` for one image.
uint64_t budgetForImage(uint64_t image_bytes) noexcept;

/// Returns the number of threads that can encode tiles of an image that uses `image_bytes`: the requested
/// number, or fewer if their encoders and the image would not fit in memory.
unsigned encoderThreads(uint64_t memory_bytes, uint64_t image_bytes, unsigned threads) noexcept;

/// Forecasts the peak memory of a build: the memory of the program plus that of the stage that needs most.
/// @param file           attributes of the PLY file.
/// @param texture_bytes  peak memory for decoding the images and encoding their tiles, in addition to the
///                       memory of the program; 0 if the model has no images.
uint64_t expectedPeakBytes(const MemoryPlan& plan, uint64_t vertices, uint64_t triangles, AttributeSet file,
                           uint32_t triangles_per_node, uint64_t texture_bytes) noexcept;

}  // namespace lode::ingest
