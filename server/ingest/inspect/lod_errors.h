#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "server/store/reader.h"

namespace lode::ingest {

struct LodAt {
  const Node* node;
  uint32_t lod;
};

/// Stored and measured error of an LOD, in lattice steps.
struct MeasuredError {
  float stored_steps = 0;
  float found_steps =
      0;  ///< for the surface and its boundaries; see LodCheck::found(), BoundaryCheck::found()
};

struct LodErrorOptions {
  uint64_t seed = 1;  ///< for points inside triangles
  unsigned threads = 1;
  std::function<void(double fraction, uint64_t leaves)>
      progress;  ///< called by one thread at a time; may throw
};

/// Measures LODs against the leaves below their nodes, independently of the build's samples. Reads each leaf
/// once for all LODs above it. Memory: a leaf per thread, and the LODs above these.
/// @param lods  with triangles. @return one result per LOD, in their order.
/// @throws Error kIo, kFormat.
std::vector<MeasuredError> measureLodErrors(const store::Reader& reader, std::span<const LodAt> lods,
                                            const LodErrorOptions& options);

}  // namespace lode::ingest
