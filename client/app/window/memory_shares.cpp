#include "client/app/window/memory_shares.h"

#include <algorithm>

#include "client/core/textures/texture_stream.h"
#include "client/render/residency/staging_ring.h"
#include "client/render/residency/texture_residency.h"

namespace lode::app {
namespace {

// A frame may upload up to 1/256 of the budget for meshes, and another 1/256 for textures.
constexpr uint64_t kStagingShare = 256;
constexpr uint64_t kPageShare = 8;  // a GPU buffer takes 1/8 of the mesh memory, but at most kBufferBytes
// Software OpenGL allocates a buffer of this size in a millisecond.
constexpr uint64_t kBufferBytes = 4u << 20;
constexpr uint64_t kSpareShare = 4;  // 1/4 of the mesh memory may hold meshes that are no longer drawn
constexpr uint64_t kWasteShare = 8;  // at most 1/8 of the mesh memory is lost at the ends of buffers

}  // namespace

/// Divides the budget. On the GPU, texture tiles get as many bytes as in the core, plus half of these bytes
/// for copying the tile array when it grows. Meshes get the rest of the GPU's half, but at least 3/8 of it.
MemoryShares shareMemory(uint64_t memory_budget_bytes) {
  MemoryShares shares;
  shares.stream_bytes = memory_budget_bytes / 2;
  const uint64_t gpu_bytes = memory_budget_bytes - shares.stream_bytes;
  render::ResidencyOptions& gpu = shares.gpu;
  const uint64_t staging_bytes = memory_budget_bytes / kStagingShare;
  gpu.staging_bytes = static_cast<uint32_t>(std::clamp<uint64_t>(staging_bytes, 256u << 10, 4u << 20));
  gpu.texture_staging_bytes = static_cast<uint32_t>(
      std::clamp<uint64_t>(staging_bytes, render::kLeastTextureStagingBytes, 4 * render::kTileLayerBytes));
  gpu.texture_budget_bytes = shares.stream_bytes / core::kTextureBudgetShare;
  const uint64_t others =
      gpu.texture_budget_bytes + gpu.texture_budget_bytes / 2 +
      render::StagingRing::kSegments * (uint64_t{gpu.staging_bytes} + gpu.texture_staging_bytes);
  const uint64_t least_bytes = gpu_bytes * 3 / 8;
  gpu.budget_bytes = std::max(gpu_bytes > others ? gpu_bytes - others : 0, least_bytes);
  gpu.page_bytes =
      static_cast<uint32_t>(std::clamp<uint64_t>(gpu.budget_bytes / kPageShare, 256u << 10, kBufferBytes));
  gpu.spare_bytes = gpu.budget_bytes / kSpareShare;
  shares.drawn_bytes = gpu.budget_bytes - gpu.budget_bytes / kWasteShare;
  return shares;
}

stream::StreamOptions withShare(stream::StreamOptions options, const MemoryShares& memory) {
  options.engine.memory_budget_bytes = memory.stream_bytes;
  options.engine.refine.drawn_budget_bytes = memory.drawn_bytes;
  return options;
}

}  // namespace lode::app
