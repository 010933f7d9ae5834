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

/// An LOD's surface, and which points of the LOD and of its input correspond.
struct LodPlaces {
  const LodSurface& surface;
  std::span<const SurfaceWalk::Place> of_input;
  std::span<const uint32_t> sources;
};

struct LodDeviation {
  float steps = 0;
  /// Farthest point of the original; its `near` is a position of the input. Set only if the LOD's input is
  /// the original and the point lies inside a triangle, so that samples would miss it.
  std::optional<SurfaceSample> farthest;
};

/// Estimates the largest distance between an LOD and the original, in lattice steps. The result is usually
/// too large. Measures the distance between the LOD and its input in both directions. If the input is not the
/// original, deviationOfReduced() combines this distance with the input's own deviation.
/// @param farthest_sample  largest distance of a sample from the LOD.
LodDeviation lodDeviation(const SimplifiedMesh& lod, const LodInput& input, const LodPlaces& places,
                          float farthest_sample);

/// Returns the deviation from the original of an LOD whose input is not the original. Combines `from_input`
/// and `off` as independent errors: the root of the sum of squares. The plain sum would be 2 to 5 times too
/// large. Over many levels the root also becomes too large, because an LOD cancels some of its input's
/// deviation. Large LODs therefore rely on samples of the original: many places of a large LOD deviate nearly
/// as much as the worst place, and some samples are near one of them.
/// @param from_input  distance between the LOD and its input. @param off  deviation of the input from the
/// original.
/// @param triangles  number of triangles in the LOD. @return at least each of the three distances.
float deviationOfReduced(float from_input, float off, float farthest_sample, size_t triangles);

}  // namespace lode::ingest
