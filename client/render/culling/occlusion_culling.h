#pragma once

#include <cstdint>

namespace lode::render {

/// How clusters hidden by other geometry are culled. The picture is the same with each.
enum class OcclusionCulling : uint8_t {
  kOff,
  kReadBack,  ///< the CPU reads the depth back, which blocks, and tests clusters
  kOnGpu,     ///< compute shaders test clusters; nothing blocks
};

/// True if the current context renders on the CPU. Reading back then costs nothing but the wait.
bool drawsInSoftware();

/// Returns the fastest method in the current context.
OcclusionCulling fastestOcclusionCulling();

}  // namespace lode::render
