#pragma once

#include <memory>

#include "server/sample/sample_model.h"

namespace lode::ingest {

constexpr uint64_t kLeastTerrain = 2;  ///< triangles

/// Makes a landscape of about 2 x 2, z up, with one open boundary: ridges, terraced cliffs with overhangs and
/// flat lakes, coloured by height and slope. More triangles show the same land in more detail.
/// @param triangles  maximum, at least kLeastTerrain.
std::unique_ptr<SampleModel> makeTerrain(uint64_t triangles, uint64_t seed, AttributeSet attributes);

}  // namespace lode::ingest
