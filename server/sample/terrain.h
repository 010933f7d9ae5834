#pragma once

#include <memory>

#include "server/sample/sample_model.h"

namespace lode::ingest {

constexpr uint64_t kLeastTerrain = 2;  ///< smallest possible number of triangles

/// Creates a landscape of about 2 x 2, z up, with one open boundary. The land has ridges, terraced cliffs
/// with overhangs and flat lakes, and its colours depend on height and slope. More triangles show the same
/// land in more detail.
/// @param triangles  maximum number of triangles, at least kLeastTerrain.
std::unique_ptr<SampleModel> makeTerrain(uint64_t triangles, uint64_t seed, AttributeSet attributes);

}  // namespace lode::ingest
