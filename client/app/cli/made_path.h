#pragma once

#include <cstdint>

#include "client/core/view/camera_path.h"

namespace lode::app {

/// Camera paths for who has recorded none.
enum class MadePath : uint8_t {
  kOrbit,  ///< 20 s once around the model, half as far away in the end
  kFly,    ///< 20 s from one side of the model's box through it to the other, looking ahead
  kWalk,   ///< 60 s from place to place around the model, near and far, looking at one point of it after
           ///< another
};

/// @param seed  of the places that a path goes by; of the direction in which an orbit begins, 0: where the
/// framing
///              camera is.
core::CameraPath makePath(MadePath kind, const ModelSummary& model, uint64_t seed);

}  // namespace lode::app
