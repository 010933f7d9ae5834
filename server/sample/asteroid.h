#pragma once

#include <memory>

#include "server/sample/sample_model.h"

namespace lode::ingest {

constexpr uint64_t kLeastAsteroid = 12;  ///< smallest possible number of triangles

/// Creates a closed connected surface: a ball of radius about 1 with relief down to the size of triangles.
/// More triangles show the same relief in more detail.
/// @param triangles  maximum number of triangles, at least kLeastAsteroid.
std::unique_ptr<SampleModel> makeAsteroid(uint64_t triangles, uint64_t seed, AttributeSet attributes);

}  // namespace lode::ingest
