#pragma once

#include <cstdint>

#include "client/render/residency/mesh_residency.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// Division of a program's memory budget. One half is for the client core, the other half for the copies on
/// the GPU.
struct MemoryShares {
  uint64_t stream_bytes = 0;  ///< budget of the client core, see EngineOptions::memory_budget_bytes
  /// Value of RefineOptions::drawn_budget_bytes. Meshes of any sizes that take this many bytes together fit
  /// on the GPU.
  uint64_t drawn_bytes = 0;
  /// Budgets of the GPU's half. With memory budgets below 32 MB, the upload buffers exceed this half.
  render::ResidencyOptions gpu;
};

/// Divides a memory budget. Pure.
MemoryShares shareMemory(uint64_t memory_budget_bytes);

/// Returns the options with the budgets of the stream's share.
stream::StreamOptions withShare(stream::StreamOptions options, const MemoryShares& memory);

}  // namespace lode::app
