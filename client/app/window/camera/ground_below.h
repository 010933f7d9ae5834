#pragma once

#include <optional>

#include "client/app/window/camera/walk_camera.h"
#include "client/core/lod/cut_probe.h"

namespace lode::app {

/// What a cut has straight below a point, where the camera does not look: its own part, or a coarser one
/// where that is not there.
/// @param view  the camera's, for its picture's angles. @param up  of unit length.
std::optional<render::Ground> groundBelow(const core::CutProbe& probe, const core::View& view,
                                          const glm::dvec3& point_model, const glm::dvec3& up);

}  // namespace lode::app
