#include "server/ingest/plan/memory_plan.h"

#include <algorithm>

#include "common/byte_size.h"
#include "server/ingest/mesh/soup_triangle.h"

namespace lode::ingest {
namespace {

constexpr uint64_t kProgramBytes = 24 << 20;  ///< memory of code and file buffers
constexpr uint64_t kMarginBytes = 24 << 20;   ///< freed memory that the allocator keeps from earlier stages
/// Memory of all finished nodes that wait for their parents to be built, in bytes per triangle of the node
/// capacity. Most builds need only half of this.
constexpr uint64_t kFrontierBytes = 5 << 10;
constexpr uint64_t kWorkerBytes = 2816;  ///< bytes per thread and triangle of the node capacity
/// Memory per triangle of a large node, that is, a node whose LODs are written to disk.
/// kLargeNodeBytesWithAttributes is for models whose quadrics include attributes.
constexpr uint64_t kLargeNodeBytes = 300, kLargeNodeBytesWithAttributes = 360;
/// Memory per triangle of a small model: kSmallModelBytes for the nodes that threads simplify,
/// kGrowingFrontierBytes for finished nodes that wait for their parents.
constexpr uint64_t kSmallModelBytes = 704, kGrowingFrontierBytes = 64;
constexpr uint64_t kEncoderBytes = 20 << 20;  ///< memory of a thread's tile, encoder and encoded tiles
constexpr uint64_t kBesideImage = kProgramBytes + kEncoderBytes;
constexpr uint64_t kSortOrderBytes = 16;    ///< memory of a sort per record, in addition to the record itself
constexpr uint64_t kBatchVertexBytes = 20;  ///< memory of a batch per vertex: position and attributes
/// Typical values for forecasts: memory of the program, and the fraction of the planned memory that nodes
/// really use.
constexpr uint64_t kUsualProgramBytes = 14 << 20;
constexpr double kUsualShare = 0.75, kUsualShareWithoutAttributes = 0.5;
constexpr double kGrowth = 1.25;  ///< ratio of a growing buffer's capacity to its size

}  // namespace

MemoryPlan planMemory(uint64_t memory_bytes, unsigned threads, uint32_t triangles_per_node) noexcept {
  const uint64_t base = kProgramBytes + kMarginBytes + triangles_per_node * kFrontierBytes;
  const uint64_t worker = triangles_per_node * kWorkerBytes;
  const uint64_t left = memory_bytes > base ? memory_bytes - base : 0;
  const uint64_t fitting = std::clamp<uint64_t>(left / worker, 1, std::max(1u, threads));
  MemoryPlan plan;
  plan.sort_bytes = memory_bytes / 4;
  plan.threads = static_cast<unsigned>(fitting);
  plan.image_bytes = std::max(memory_bytes / 2, memory_bytes - std::min(memory_bytes, kBesideImage));
  plan.node_bytes = memory_bytes - std::min(memory_bytes, kProgramBytes + kMarginBytes);
  plan.minimum_bytes = base + worker;
  return plan;
}

std::string smallBudgetInWords(uint64_t memory_bytes, uint32_t triangles_per_node, bool is_one_node) {
  const uint64_t least =
      is_one_node ? kUsualProgramBytes : planMemory(memory_bytes, 1, triangles_per_node).minimum_bytes;
  if (memory_bytes >= least) return {};
  return budgetBelowInWords(
      least, is_one_node ? "the program itself" : std::to_string(triangles_per_node) + " triangles per node");
}

std::string budgetBelowInWords(uint64_t least_bytes, const std::string& purpose) {
  return "--memory is less than the " + byteSizeAtLeast(least_bytes) + " needed for " + purpose +
         "; the build may use more";
}

uint64_t memoryForLargeNode(uint64_t triangles, AttributeSet attributes) noexcept {
  const bool has_quadrics =
      attributes.has(AttributeSet::kNormal | AttributeSet::kColour | AttributeSet::kTexture);
  return kProgramBytes + triangles * (has_quadrics ? kLargeNodeBytesWithAttributes : kLargeNodeBytes);
}

uint64_t budgetForImage(uint64_t image_bytes) noexcept {
  return image_bytes + std::min(image_bytes, kBesideImage);
}

unsigned encoderThreads(uint64_t memory_bytes, uint64_t image_bytes, unsigned threads) noexcept {
  const uint64_t used = kProgramBytes + image_bytes;
  const uint64_t fitting = memory_bytes > used ? (memory_bytes - used) / kEncoderBytes : 0;
  return static_cast<unsigned>(std::clamp<uint64_t>(fitting, 1, std::max(1u, threads)));
}

uint64_t expectedPeakBytes(const MemoryPlan& plan, uint64_t vertices, uint64_t triangles, AttributeSet file,
                           uint32_t triangles_per_node, uint64_t texture_bytes) noexcept {
  const uint64_t records = triangles * (soupBytes(file) + kSortOrderBytes);
  const uint64_t corner_bytes = sizeof(uint32_t) + (file.has(AttributeSet::kTexture) ? sizeof(uint32_t) : 0);
  const uint64_t batch = triangles * 3 * corner_bytes + vertices * kBatchVertexBytes;
  const uint64_t sort =
      static_cast<uint64_t>(kGrowth * static_cast<double>(std::min(records, plan.sort_bytes))) +
      std::min(batch, plan.sort_bytes / 2);
  const uint64_t workers =
      std::min(triangles_per_node * plan.threads * kWorkerBytes, triangles * kSmallModelBytes);
  const uint64_t frontier =
      std::min(triangles_per_node * kFrontierBytes / 2, triangles * kGrowingFrontierBytes);
  const double share = file.bits == 0 ? kUsualShareWithoutAttributes : kUsualShare;
  const auto simplify = static_cast<uint64_t>(share * static_cast<double>(workers + frontier));
  return kUsualProgramBytes + std::max({sort, simplify, texture_bytes});
}

}  // namespace lode::ingest
