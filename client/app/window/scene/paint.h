#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "client/core/lod/cut.h"
#include "client/core/lod/cut_probe.h"

namespace lode::core {

/// The colour of a model where a ray has met it, sRGB: of the vertices, between them, and of the finest texel
/// that is there, mixed in linear light as they are drawn. Nothing where it has neither.
/// @param textured  a cut of the same model with its textures: those of a place have none.
std::optional<glm::u8vec3> paintAt(const Hit& hit, const Cut& textured);

}  // namespace lode::core
