#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "server/ingest/mesh/soup_triangle.h"
#include "server/ingest/plan/build_options.h"
#include "server/ingest/soup/lattice_choice.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

struct DereferenceCounts {
  uint64_t triangles = 0;       ///< given out
  uint64_t dropped = 0;         ///< triangles whose corners do not stay distinct on the lattice
  uint64_t lost = 0;            ///< of these, those whose corners the file has in three places
  double snap_error_steps = 0;  ///< the farthest that a vertex was moved
};

/// Where a batch of faces begins, and what was given out before.
struct DereferencePoint {
  uint64_t face_offset = 0;  ///< of PackedInput's cursor
  uint64_t faces = 0;
  DereferenceCounts counts;
};

/// Takes triangles in the input's order.
using SoupSink = std::function<void(std::span<const SoupTriangle>)>;
using BatchSink = std::function<void(const DereferencePoint&)>;

/// Stage 2: indices become positions and attributes. Polygons are cut into triangles here, where positions
/// are known, and a vertex whose normal has no length gets that of the face at each of its corners. As many
/// faces as fit in half of the memory are read, the vertices that they use are swept up from the packed file
/// in one pass over it that skips what is not needed, and the triangles are given out, in the file's order;
/// then the next. Threads share both, vertices by ranges and triangles by
/// blocks of faces, as many as half of what the faces leave of the memory holds the soup of.
/// @param sink      called by the caller's thread.
/// @param from      a point that on_batch was told, to go on from; the counts returned include those before.
/// @param on_batch  told of each batch before its first triangle is given out.
DereferenceCounts dereference(const PackedInput& input, const Lattice& lattice, uint64_t memory_bytes,
                              unsigned threads, const SoupSink& sink, const BuildProgress& progress,
                              const DereferencePoint& from = {}, const BatchSink& on_batch = {});

}  // namespace lode::ingest
