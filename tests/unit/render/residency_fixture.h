#pragma once

#include <cstdint>
#include <memory>

#include "gl_fixture.h"
#include "tests/support/test_meshes.h"

namespace lode::test {

using Residency = GlTest;

/// Grids of one size take the same memory, whatever their seed.
inline std::shared_ptr<const Mesh> gridOf(uint32_t seed, uint32_t side = 32) {
  return std::make_shared<const Mesh>(makeGrid(side, side, {.attributes = {}, .seed = seed}));
}

}  // namespace lode::test
