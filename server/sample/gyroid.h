#pragma once

#include <memory>

#include "server/sample/sample_model.h"

namespace lode::ingest {

constexpr uint64_t kLeastGyroid = 2880;  ///< triangles

/// A porous block, closed and manifold: the solid of the gyroid in many periods, rough and bent, like stone
/// or bone. Its longest side is about 2. A mesh of more triangles has more pores and shows each in more
/// detail, up to 24 steps a period; from there on only their number grows.
/// @param triangles  at most this many, at least kLeastGyroid.
std::unique_ptr<SampleModel> makeGyroid(uint64_t triangles, uint64_t seed, AttributeSet attributes);

}  // namespace lode::ingest
