#pragma once

#include <cstdint>

namespace lode::render {

/// What is done with clusters in the picture that others hide. The picture is the same.
enum class HiddenParts : uint8_t {
  kDrawn,
  kReadBack,    ///< left out by the depth of the rest, which the processor waits for
  kFoundOnGpu,  ///< left out by the GPU, which nobody waits for
};

/// True where pictures are drawn by the processor: there, what is drawn can be read back at no cost but the
/// wait for it. Of the current context.
bool drawsInSoftware();

/// What is fastest in the current context.
HiddenParts fastestHiddenParts();

}  // namespace lode::render
