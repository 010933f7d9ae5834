#pragma once

#include <string>

#include <glm/glm.hpp>

#include "server/ingest/inspect/lod_errors.h"
#include "server/store/reader.h"

namespace lode::ingest {

/// A point that shows the deviation of an LOD, in true coordinates and model units, so that any program can
/// check it.
struct ErrorWitness {
  NodeKey node;
  uint32_t lod = 0;
  double stored_error = 0;
  double distance = 0;       ///< distance between the next two points
  glm::dvec3 point{0};       ///< a point of the LOD, or of the original triangles below its node
  glm::dvec3 nearest{0};     ///< the point of the other surface or of its boundary that is nearest to `point`
  bool of_lod = false;       ///< `point` is on the LOD
  bool on_boundary = false;  ///< `distance` is the distance between boundaries
};

/// Measures the distance of a point again, in double precision. The point is on an LOD or on the leaves below
/// the LOD's node. The function compares the point with every triangle of the other surface, or with every
/// boundary edge.
/// @throws Error kIo, kFormat.
ErrorWitness witnessOf(const store::Reader& reader, const LodAt& lod, const MeasuredError& measured);

/// Describes a witness, such as "node root/3, LOD 2: its stored error is 0.5, but the point (1 2 3) of …".
std::string describe(const ErrorWitness& witness);

}  // namespace lode::ingest
