#pragma once

#include <cstdint>

namespace lode::render {

/// Method of culling clusters that other geometry hides. All methods draw the same picture.
enum class OcclusionCulling : uint8_t {
  kOff,       ///< draws hidden clusters too
  kReadBack,  ///< the CPU reads the depth back, which blocks, and tests clusters
  kOnGpu,     ///< compute shaders test clusters, without blocking
};

/// Returns true if the current context renders on the CPU. In such a context, reading depth back costs only
/// the wait for drawing.
bool drawsInSoftware();

/// Returns the fastest method in the current context.
OcclusionCulling fastestOcclusionCulling();

}  // namespace lode::render
