#pragma once

#include <memory>

#include "server/sample/sample_model.h"

namespace lode::ingest {

constexpr uint64_t kLeastAsteroid = 12;  ///< triangles

/// A closed surface of one piece: a cube of n x n squares a side, blown up to a ball of radius about 1 with
/// relief of all sizes down to the triangles'; a mesh of more triangles shows the same relief in more detail.
/// @param triangles  at most this many, at least kLeastAsteroid.
std::unique_ptr<SampleModel> makeAsteroid(uint64_t triangles, uint64_t seed, AttributeSet attributes);

}  // namespace lode::ingest
