#pragma once

#include <memory>

#include "server/sample/sample_model.h"

namespace lode::ingest {

constexpr uint64_t kLeastTerrain = 2;  ///< triangles

/// A landscape of about 2 x 2, z up, with one open boundary: ridges, terraced cliffs with overhanging strata,
/// lakes that are flat; painted by height and slope. A mesh of more triangles shows the same land in more
/// detail.
/// @param triangles  at most this many, at least kLeastTerrain.
std::unique_ptr<SampleModel> makeTerrain(uint64_t triangles, uint64_t seed, AttributeSet attributes);

}  // namespace lode::ingest
