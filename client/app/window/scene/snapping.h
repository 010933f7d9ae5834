#pragma once

#include <array>

#include "client/app/window/scene/picked_point.h"
#include "client/core/lod/cut_probe.h"

namespace lode::app {

// A point that was picked on a coarse surface is picked anew once the surface is finer.

/// Returns the rays along which a point is picked anew, in the frame of position_model: the ray of the click,
/// which keeps the point at its place in the picture, then rays from both sides along the picked triangle's
/// normal, for a surface that the click would now miss. Pure.
std::array<core::Ray, 3> snappingRays(const PickedPoint& point) noexcept;

/// Returns true if a point of a finer surface may be the place that the user has picked: both surfaces are
/// within their errors of the original. A ray that meets them at a slant finds points farther apart. Pure.
/// @param along  one of snappingRays().
bool isSamePlace(const PickedPoint& point, const core::Ray& along, const PickedPoint& finer) noexcept;

}  // namespace lode::app
