#pragma once

#include <cstdint>

#include "client/core/view/camera_path.h"

namespace lode::app {

/// Camera paths that makePath() computes.
enum class MadePath : uint8_t {
  kOrbit,  ///< flies once around the model in 20 s; the distance halves meanwhile
  kFly,    ///< flies through the model's box in 20 s, from one side to the other, looking ahead
  kWalk,   ///< moves around the model for 60 s, near and far, and looks at changing points
};

/// Returns a camera path around a model.
/// @param seed  number that chooses the positions of a path and the start of an orbit. An orbit with seed 0
///              starts at the framing camera.
core::CameraPath makePath(MadePath kind, const ModelSummary& model, uint64_t seed);

}  // namespace lode::app
