#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "client/core/lod/cut.h"
#include "client/core/lod/cut_probe.h"

namespace lode::app {

/// Returns the sRGB colour at a hit. Multiplies the interpolated vertex colour by the finest resident texel
/// in linear light, like the renderer. Returns nothing if the model has neither colours nor a texture.
/// @param textured  union of the model's cuts (core::ViewCuts::all), which has the textures; the cuts of
/// single instances have none.
std::optional<glm::u8vec3> paintAt(const core::Hit& hit, const core::Cut& textured);

}  // namespace lode::app
