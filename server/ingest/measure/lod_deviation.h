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

/// Data for measuring an LOD; see placesOn(), sourcesOf().
struct LodPlaces {
  const LodSurface& surface;
  std::span<const SurfaceWalk::Place> of_input;
  std::span<const uint32_t> sources;
};

struct LodDeviation {
  float steps = 0;
  /// Farthest point of the original, near a position of the input. Set only if the LOD was made of the
  /// original and the point is inside a triangle, where samples would miss it.
  std::optional<SurfaceSample> farthest;
};

/// Largest distance between an LOD and the original, in lattice steps, usually overestimated: the distance
/// between the LOD and its input in both directions, and if the input is not the original, combined by
/// deviationOfReduced().
/// @param farthest_sample  largest distance of a sample from the LOD.
LodDeviation lodDeviation(const SimplifiedMesh& lod, const LodInput& input, const LodPlaces& places,
                          float farthest_sample);

/// Deviation of an LOD whose input is already reduced. Adds the input's deviation as an independent error,
/// and takes samples of the original into account. (A plain sum would overestimate 2 to 5 times.) Over many
/// levels even this overestimates, because an LOD cancels some of its input's deviation. A large LOD has many
/// places that are nearly as bad as its worst, and samples do not miss all of them, so its samples are
/// trusted.
/// @param from_input  distance between the LOD and its input. @param off  deviation of the input.
/// @param triangles  of the LOD. @return at least each of the three distances.
float deviationOfReduced(float from_input, float off, float farthest_sample, size_t triangles);

}  // namespace lode::ingest
