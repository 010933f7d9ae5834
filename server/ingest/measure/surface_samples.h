#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/ingest/measure/rung_input.h"
#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/simplified_mesh.h"

namespace lode::ingest {

/// A point of the original surface that travels up the tree, with the largest deviation from it that any rung
/// on the way had, in lattice steps.
struct SurfaceSample {
  PositionCode position;
  float deviation = 0;
  uint32_t near = kVanished;  ///< what has become of the place in the mesh at hand: one of its positions
};

/// Keeps at most `capacity` samples, in their order: half of them those with the largest deviations, the
/// others those with the lowest hash of position, an unbiased choice that does not depend on the order where
/// positions are distinct.
void selectSamples(std::vector<SurfaceSample>& samples, size_t capacity);

/// Of samples with one position, leaves the one with the largest deviation; sorts by position.
void dropDuplicates(std::vector<SurfaceSample>& samples);

/// Where each position of the mesh that a rung was made of lies on the rung; of those that have vanished,
/// anything. @param walk  over the rung's mesh.
std::vector<SurfaceWalk::Place> placesOn(const SimplifiedMesh& rung, const NodeMesh& input,
                                         const SurfaceWalk& walk);

/// Distances of samples, which are near positions of the mesh that `rung` was made of, from the rung, lattice
/// steps: the largest is exact, and no other below the true one.
/// @param walk  over the rung's mesh. @param places  of the input's positions, which samples may be.
std::vector<float> deviationsFrom(const SimplifiedMesh& rung, const NodeMesh& input, const SurfaceWalk& walk,
                                  std::span<const SurfaceWalk::Place> places,
                                  std::span<const SurfaceSample> samples);

/// Points inside the triangles of a mesh that are large beside the others, where its positions alone would
/// say little: one for every two mean areas, in a small mesh for every half.
std::vector<SurfaceSample> samplesInside(const NodeMesh& mesh);

/// The largest distance of a rung from the mesh that it was made of, lattice steps: of its vertices, and
/// where it has so few triangles that these may miss the worst, of points between them. Never below theirs.
/// @param sources  see sourcesOf().
float farthestPlace(const SimplifiedMesh& rung, const RungInput& input, std::span<const uint32_t> sources);

}  // namespace lode::ingest
