#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "client/core/lod/cut.h"
#include "client/core/lod/cut_probe.h"

namespace lode::core {

/// Returns the colour at a hit, sRGB: the interpolated vertex colour times the finest resident texel, in
/// linear light as they are drawn. Nothing if the model has neither.
/// @param textured  a cut of the model with its textures; cuts of instances have none.
std::optional<glm::u8vec3> paintAt(const Hit& hit, const Cut& textured);

}  // namespace lode::core
