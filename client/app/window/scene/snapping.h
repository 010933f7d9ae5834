#pragma once

#include <array>

#include "client/app/window/scene/picked_point.h"
#include "client/core/lod/cut_probe.h"

namespace lode::app {

// A point that was picked on a coarse surface is picked anew once the surface is finer.

/// Returns the rays along which to pick a point anew, in the frame of position_model. The first ray is that
/// of the click, which keeps the point at its place in the picture. The others follow the picked triangle's
/// normal from both sides, in case the click would miss the finer surface. Pure.
std::array<core::Ray, 3> snappingRays(const PickedPoint& point) noexcept;

/// Returns true if a point of a finer surface may be the place that the user has picked. Allows for the
/// errors of both surfaces, and for a ray that meets them at a slant. Pure.
/// @param along  one of snappingRays().
bool isSamePlace(const PickedPoint& point, const core::Ray& along, const PickedPoint& finer) noexcept;

}  // namespace lode::app
