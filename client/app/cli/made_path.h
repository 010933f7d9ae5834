#pragma once

#include <cstdint>

#include "client/core/view/camera_path.h"

namespace lode::app {

/// Camera paths that need no recording.
enum class MadePath : uint8_t {
  kOrbit,  ///< 20 s: one turn around the model while the distance halves
  kFly,    ///< 20 s: through the model's box from one side to the other, looking ahead
  kWalk,   ///< 60 s: between positions around the model, near and far, looking at changing points
};

/// Returns a camera path around a model.
/// @param seed  chooses the positions of a path and the start of an orbit; an orbit of seed 0 starts at the
///              framing camera.
core::CameraPath makePath(MadePath kind, const ModelSummary& model, uint64_t seed);

}  // namespace lode::app
