#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/ingest/simplified_mesh.h"
#include "server/ingest/surface_walk.h"

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

/// Measures the samples, which are near positions of the mesh that `rung` was made of, against the rung and
/// raises their deviations. @return the largest distance, lattice steps; never below the true one.
/// @param walk  over the rung's mesh. @param places  of the input's positions, which samples may be.
float measureDeviation(const SimplifiedMesh& rung, const NodeMesh& input, const SurfaceWalk& walk,
                       std::span<const SurfaceWalk::Place> places, std::vector<SurfaceSample>& samples);

/// Points inside the triangles of a mesh that are large beside the others, where its positions alone would
/// say little: one for every two mean areas, in a small mesh for every half.
std::vector<SurfaceSample> samplesInside(const NodeMesh& mesh);

/// The largest distance of a rung from the mesh that it was made of, lattice steps: of its vertices, and
/// where it has so few triangles that these may miss the worst, of points between them. Never below theirs.
/// @param input  the mesh that the rung was made of. @param sources  see sourcesOf(). @param walk  over
/// input.
float farthestPlace(const SimplifiedMesh& rung, const NodeMesh& input, std::span<const uint32_t> sources,
                    const SurfaceWalk& walk);

}  // namespace lode::ingest
