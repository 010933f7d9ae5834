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
  uint64_t triangles = 0;       ///< triangles passed to the sink
  uint64_t dropped = 0;         ///< triangles whose corners coincide on the lattice
  uint64_t lost = 0;            ///< dropped triangles with distinct corners in the file
  double snap_error_steps = 0;  ///< largest distance that snapping moved a vertex, in lattice steps
};

/// Start of a batch of faces, and the counts of the faces before the batch.
struct DereferencePoint {
  uint64_t face_offset = 0;  ///< FaceCursor::offset() at the start of the batch
  uint64_t faces = 0;
  DereferenceCounts counts;
};

/// Receives triangles in file order.
using SoupSink = std::function<void(std::span<const SoupTriangle>)>;

struct DereferenceInput {
  const PackedInput& input;
  Lattice lattice;
  uint64_t memory_bytes = 0;
  unsigned threads = 1;
  BuildProgress progress{};
  /// Where to start: the first face, or the argument of an earlier call of on_batch(); the result includes
  /// the counts before this point.
  DereferencePoint from{};
  /// Called before the first triangle of each batch.
  std::function<void(const DereferencePoint&)> on_batch{};
};

/// Replaces vertex indices by lattice positions and attributes. Cuts polygons into triangles. If a vertex's
/// normal has length zero, uses the normal of the face instead. Works in batches of as many faces as fit in
/// half of the memory. For each batch, reads the vertices that the batch uses in one pass over the vertex
/// file, then passes the triangles to the sink. Threads share the pass by ranges of vertices, and the
/// triangles by blocks of faces. The memory limits the number of threads.
/// @param sink  receives the triangles, on the caller's thread.
DereferenceCounts dereference(const DereferenceInput& input, const SoupSink& sink);

}  // namespace lode::ingest
