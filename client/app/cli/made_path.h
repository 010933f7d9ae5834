#pragma once

#include <cstdint>

#include "client/core/view/camera_path.h"

namespace lode::app {

/// Kinds of camera paths that makePath() generates.
enum class MadePath : uint8_t {
  kOrbit,  ///< circles the model once in 20 s while the distance to the model halves
  kFly,    ///< flies through the model's box in 20 s, from one side to the other, and looks ahead
  kWalk,   ///< wanders around the model for 60 s at varying distances, and looks at varying points
};

/// Returns a camera path around a model.
/// @param seed  seed of the random positions of kFly and kWalk, and of the start angle of kOrbit. With seed
/// 0, an orbit starts at the default camera (core::framingCamera()).
core::CameraPath makePath(MadePath kind, const ModelSummary& model, uint64_t seed);

}  // namespace lode::app
