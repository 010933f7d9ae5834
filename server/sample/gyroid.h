#pragma once

#include <memory>

#include "server/sample/sample_model.h"

namespace lode::ingest {

constexpr uint64_t kLeastGyroid = 2880;  ///< smallest possible number of triangles

/// Creates a closed, manifold, porous block like stone or bone: many periods of a gyroid, roughened and bent.
/// The longest side of the block is about 2. More triangles give more pores and more detail. Once a period
/// has 24 grid steps, more triangles give only more pores.
/// @param triangles  maximum number of triangles, at least kLeastGyroid.
std::unique_ptr<SampleModel> makeGyroid(uint64_t triangles, uint64_t seed, AttributeSet attributes);

}  // namespace lode::ingest
