#pragma once

#include <cstdint>

namespace lode::render {

/// Method of culling clusters that other geometry hides. All methods draw the same picture.
enum class OcclusionCulling : uint8_t {
  kOff,       ///< draws hidden clusters too
  kReadBack,  ///< the CPU reads back the depth, which blocks, and tests the clusters
  kOnGpu,     ///< compute shaders test the clusters, without blocking
};

/// Returns true if the current context renders on the CPU. If so, reading back the depth costs no more than
/// waiting until drawing is done.
bool drawsInSoftware();

/// Returns the fastest method in the current context.
OcclusionCulling fastestOcclusionCulling();

}  // namespace lode::render
