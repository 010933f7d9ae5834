#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "server/ingest/inspect/lod_check.h"
#include "server/store/reader.h"

namespace lode::ingest {

struct LodAt {
  const Node* node;
  uint32_t lod;
};

/// Stored error of an LOD in lattice steps, and the point where the LOD deviates most from the leaves below
/// its node.
struct MeasuredError {
  double stored_steps = 0;
  /// The farther of two points: LodCheck::farthest(), and BoundaryCheck::farthest() for this LOD.
  FarPoint found;
};

struct LodErrorOptions {
  uint64_t seed = 1;  ///< seed that selects points inside triangles
  unsigned threads = 1;
  /// Function that receives the progress. One thread at a time calls the function; it may throw.
  std::function<void(double fraction, uint64_t leaves)> progress;
};

/// Measures the distance between LODs and the leaves below their nodes, independently of the build's samples.
/// Reads each leaf once, for all LODs above it. Keeps in memory one leaf per thread and the LODs above these
/// leaves.
/// @param lods  the LODs to measure; each has triangles. @return one result per LOD, in the order of `lods`.
/// @throws Error kIo, kFormat.
std::vector<MeasuredError> measureLodErrors(const store::Reader& reader, std::span<const LodAt> lods,
                                            const LodErrorOptions& options);

}  // namespace lode::ingest
