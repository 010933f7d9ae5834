#pragma once

#include <cstdint>

#include "client/render/residency/mesh_residency.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// Shares of the program's memory budget: half for the client core, and half for its copies on the GPU.
struct MemoryShares {
  uint64_t stream_bytes = 0;  ///< budget of the client core; see EngineOptions::memory_budget_bytes
  /// Value for RefineOptions::drawn_budget_bytes. Any meshes that take at most this many bytes in total fit
  /// on the GPU.
  uint64_t drawn_bytes = 0;
  /// Budgets for the GPU. Their sum is half of the memory budget, or more if the memory budget is below 32
  /// MB, because the upload buffers have a smallest size.
  render::ResidencyOptions gpu;
};

/// Divides a memory budget. Pure.
MemoryShares shareMemory(uint64_t memory_budget_bytes);

/// Returns the options with the memory budgets of the stream set to its share.
stream::StreamOptions withShare(stream::StreamOptions options, const MemoryShares& memory);

}  // namespace lode::app
