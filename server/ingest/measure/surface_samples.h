#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/ingest/measure/lod_surface.h"
#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// A point of the original surface that travels up the tree, with its distance from the mesh at hand, in
/// lattice steps.
struct SurfaceSample {
  PositionCode position;
  float deviation = 0;        ///< at most a quarter of the mesh's largest too much
  uint32_t near = kVanished;  ///< what has become of the place in the mesh at hand: one of its positions, or
                              ///< one near it where the place's own triangles have gone
};

/// Thins samples out, in their order: of those near each position the one with the largest deviation stays,
/// so that no piece of the mesh is ever without one; of the others those with the largest, to `capacity` in
/// all.
/// @param positions  of the mesh that samples are near to.
void selectSamples(std::vector<SurfaceSample>& samples, size_t positions, size_t capacity);

/// Adds the positions of a node's coarsest mesh that are locked in it: they have never moved and are points
/// of the original, whatever samples have been thinned out. @param depth  the node's.
void addLockedPositions(std::vector<SurfaceSample>& samples, const NodeMesh& mesh, int depth);

/// Of samples that have the same position and are near the same, leaves the one with the largest deviation;
/// sorts by position.
void dropDuplicates(std::vector<SurfaceSample>& samples);

/// Where each position of the mesh that an LOD was made of lies on the LOD; of those that have vanished,
/// anything. @param walk  over the LOD's mesh.
std::vector<SurfaceWalk::Place> placesOn(const SimplifiedMesh& lod, const NodeMesh& input,
                                         const SurfaceWalk& walk);

/// Distance of a sample from an LOD, lattice steps.
struct Deviation {
  float steps;
  uint32_t near;  ///< as SurfaceSample's, in the LOD
};

/// Distances of samples, which are near positions of the mesh that `lod` was made of, from the LOD: the
/// largest is exact, and no other below the true one.
/// @param surface  of the LOD. @param places  of the input's positions, which samples may be.
std::vector<Deviation> deviationsFrom(const SimplifiedMesh& lod, const NodeMesh& input,
                                      const LodSurface& surface, std::span<const SurfaceWalk::Place> places,
                                      std::span<const SurfaceSample> samples);

/// Points inside the triangles of a mesh that are large beside the others, where its positions alone would
/// say little: one for every two mean areas, in a small mesh for every half.
std::vector<SurfaceSample> samplesInside(const NodeMesh& mesh);

}  // namespace lode::ingest
