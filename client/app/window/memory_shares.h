#pragma once

#include <cstdint>

#include "client/render/residency/mesh_residency.h"

namespace lode::render {

/// How a program that draws shares its memory between its client core and the copies on the GPU: one half
/// each.
struct MemoryShares {
  uint64_t stream_bytes = 0;  ///< for core::EngineOptions, as drawn_bytes
  uint64_t drawn_bytes = 0;   ///< that the core may have drawn: what fits whatever the meshes' sizes
  /// All that these allow together is the other half; below 32 MB what uploads go through comes on top.
  ResidencyOptions gpu;
};

MemoryShares shareMemory(uint64_t memory_budget_bytes);

}  // namespace lode::render
