#pragma once

#include <string>

#include <glm/glm.hpp>

#include "server/ingest/inspect/lod_errors.h"
#include "server/store/reader.h"

namespace lode::ingest {

/// A point that shows how far an LOD deviates from the input. Positions and lengths are in the coordinates
/// and units of the input file, so that any program can check them.
struct ErrorWitness {
  NodeKey node;
  uint32_t lod = 0;
  double stored_error = 0;
  double distance = 0;       ///< distance between `point` and `nearest`
  glm::dvec3 point{0};       ///< a point of the LOD, or of the original triangles below its node
  glm::dvec3 nearest{0};     ///< the point of the other surface or of its boundary that is nearest to `point`
  bool of_lod = false;       ///< true if `point` is on the LOD
  bool on_boundary = false;  ///< true if `distance` is the distance between boundaries
};

/// Measures again, in double precision, how far the point in `measured` is from the other surface: from the
/// leaves below the LOD's node if the point is on the LOD, otherwise from the LOD. Compares the point with
/// every triangle of that surface, or with every boundary edge if the point is on a boundary.
/// @throws Error kIo, kFormat.
ErrorWitness witnessOf(const store::Reader& reader, const LodAt& lod, const MeasuredError& measured);

/// Describes a witness, such as "node root/3, LOD 2: its stored error is 0.5, but the point (1 2 3) of …".
std::string describe(const ErrorWitness& witness);

}  // namespace lode::ingest
