#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "server/ingest/measure/lod_input.h"
#include "server/ingest/measure/lod_surface.h"
#include "server/ingest/measure/surface_samples.h"
#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// What an LOD is measured with; see placesOn(), sourcesOf().
struct LodPlaces {
  const LodSurface& surface;
  std::span<const SurfaceWalk::Place> of_input;
  std::span<const uint32_t> sources;
};

struct LodDeviation {
  float steps = 0;
  /// Where the original is farthest, if the LOD was made of it and that is no position of it: a point that
  /// samples would miss, near a position of the input.
  std::optional<SurfaceSample> farthest;
};

/// How far an LOD and the original are from each other, lattice steps, rather too much than too little: by
/// the distance between the LOD and what it was made of, both ways, and where that is not the original
/// itself, as deviationOfReduced() says.
/// @param farthest_sample  from the LOD.
LodDeviation lodDeviation(const SimplifiedMesh& lod, const LodInput& input, const LodPlaces& places,
                          float farthest_sample);

/// The deviation of an LOD that was made of an already reduced input: by what this is off by, added as an
/// independent error, and by samples of the original. (Sums instead would be 2 to 5 times too large.) Level
/// by level that adds up to more than there is, as an LOD takes back what its input is off in places: at the
/// root of 10 million triangles to 1.9 times. In an LOD of many triangles the worst place is one of many that
/// are nearly as bad, which samples do not all miss; so they are believed there.
/// @param from_input  between the LOD and its input. @param off  what the input is off by.
/// @param triangles  of the LOD. @return not below any of the three distances.
float deviationOfReduced(float from_input, float off, float farthest_sample, size_t triangles);

}  // namespace lode::ingest
