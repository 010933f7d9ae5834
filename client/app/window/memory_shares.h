#pragma once

#include <cstdint>

#include "client/render/residency/mesh_residency.h"
#include "client/stream/streamer.h"

namespace lode::render {

/// Division of a program's memory budget between the client core and the copies on the GPU: one half each.
struct MemoryShares {
  uint64_t stream_bytes = 0;  ///< EngineOptions::memory_budget_bytes
  uint64_t drawn_bytes =
      0;  ///< EngineOptions::drawn_budget_bytes: fits on the GPU whatever the meshes' sizes
  /// Uses the other half; with budgets below 32 MB, upload buffers exceed it.
  ResidencyOptions gpu;
};

/// Divides a memory budget. Pure.
MemoryShares shareMemory(uint64_t memory_budget_bytes);

/// Returns the options with the stream's share as budgets.
stream::StreamOptions withShare(stream::StreamOptions options, const MemoryShares& memory);

}  // namespace lode::render
