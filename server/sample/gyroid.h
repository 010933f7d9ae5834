#pragma once

#include <memory>

#include "server/sample/sample_model.h"

namespace lode::ingest {

constexpr uint64_t kLeastGyroid = 2880;  ///< triangles

/// Makes a closed, manifold, porous block like stone or bone: many periods of a gyroid, roughened and bent.
/// Its longest side is about 2. More triangles give more pores and more detail, up to 24 steps per period;
/// beyond that only more pores.
/// @param triangles  maximum, at least kLeastGyroid.
std::unique_ptr<SampleModel> makeGyroid(uint64_t triangles, uint64_t seed, AttributeSet attributes);

}  // namespace lode::ingest
