#pragma once

#include <vector>

#include <glm/glm.hpp>

#include "common/image/tile_image.h"

namespace lode::core {

/// A texture's stored levels end with the first that fits one tile; seen from afar that one would sparkle.
/// The tail is what a chain of levels goes on with, down to one texel: made by the client, each in an image
/// with gutters of its own.

/// Sizes of the tail's images, gutters included, finest first. @param coarsest  of the coarsest stored level,
/// gutters included.
std::vector<glm::uvec2> tailSizes(glm::uvec2 coarsest);

/// Fills coarsest.coarser from its texels: each level the finer one halved (common/image/image.h).
void makeTail(TileImage& coarsest);

}  // namespace lode::core
