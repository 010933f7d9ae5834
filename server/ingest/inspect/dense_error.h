#pragma once

#include <cstdint>

#include "server/store/reader.h"

namespace lode::ingest {

/// A rung's stored error beside what dense sampling finds, in lattice steps.
struct DenseError {
  float stored_steps = 0;
  float forward_steps = 0;   ///< largest distance of the original surface's points from the rung
  float backward_steps = 0;  ///< largest distance of the rung's points from the original surface
};

/// Measures a rung against the leaves below its node, from points inside the triangles of both, spread by
/// area (of the original: leaf by leaf). Independent of the samples that the build carried. Memory: the rung,
/// one leaf, and the points.
/// @param rung     with triangles.
/// @param samples  points each way, about.
/// @throws Error kIo, kFormat.
DenseError measureDenseError(const store::Reader& reader, const Node& node, uint32_t rung, size_t samples,
                             uint64_t seed);

}  // namespace lode::ingest
