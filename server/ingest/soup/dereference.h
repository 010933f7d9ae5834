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
  uint64_t triangles = 0;       ///< passed to the sink
  uint64_t dropped = 0;         ///< triangles whose corners coincide on the lattice
  uint64_t lost = 0;            ///< dropped triangles whose corners are distinct in the file
  double snap_error_steps = 0;  ///< largest distance that a vertex was moved
};

/// Start of a batch of faces, and the counts before it.
struct DereferencePoint {
  uint64_t face_offset = 0;  ///< of PackedInput::FaceCursor
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
  DereferencePoint from{};  ///< an earlier on_batch point to continue from; counts include those before it
  /// Called before the first triangle of each batch.
  std::function<void(const DereferencePoint&)> on_batch{};
};

/// Replaces vertex indices by lattice positions and attributes. Cuts polygons into triangles, and gives
/// vertices whose normal has no length the normal of each face. Works in batches: reads as many faces as half
/// the memory holds, fetches their vertices in one pass over the packed file, skipping unused ranges, and
/// emits the triangles. Threads share the pass by vertex ranges and the triangles by blocks of faces; their
/// number is limited to what the memory holds. @param sink  called by the caller's thread.
DereferenceCounts dereference(const DereferenceInput& input, const SoupSink& sink);

}  // namespace lode::ingest
