#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/ingest/measure/lod_surface.h"
#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// A point of the original surface that is passed up the tree, with its distance from the current mesh in
/// lattice steps.
struct SurfaceSample {
  PositionCode position;
  float deviation = 0;        ///< overestimated by at most a quarter of the mesh's largest
  uint32_t near = kVanished;  ///< position of the current mesh that the point maps to; if its triangles have
                              ///< vanished, a nearby position
};

/// Thins out samples, keeping their order: keeps the one with the largest deviation near each position, so
/// that every piece of the mesh has one, and of the others those with the largest deviations, `capacity` in
/// all.
/// @param positions  number of positions of the mesh that samples are near to.
void selectSamples(std::vector<SurfaceSample>& samples, size_t positions, size_t capacity);

/// Adds the positions that are locked in a node's coarsest mesh: they have never moved, so they are points of
/// the original, however far samples were thinned out. @param depth  of the node.
void addLockedPositions(std::vector<SurfaceSample>& samples, const NodeMesh& mesh, int depth);

/// Removes duplicates: of samples with equal position and `near`, keeps the one with the largest deviation.
/// Sorts by position.
void dropDuplicates(std::vector<SurfaceSample>& samples);

/// Maps each position of an LOD's input to its place on the LOD; undefined for vanished positions.
/// @param walk  over the LOD's mesh.
std::vector<SurfaceWalk::Place> placesOn(const SimplifiedMesh& lod, const NodeMesh& input,
                                         const SurfaceWalk& walk);

/// Distance of a sample from an LOD, in lattice steps.
struct Deviation {
  float steps;
  uint32_t near;  ///< as SurfaceSample::near, in the LOD
};

/// Distances of samples from an LOD. The largest is exact; the others are upper bounds.
/// @param surface  of the LOD. @param places  of the input's positions. @param samples  near the input's
/// positions.
std::vector<Deviation> deviationsFrom(const SimplifiedMesh& lod, const NodeMesh& input,
                                      const LodSurface& surface, std::span<const SurfaceWalk::Place> places,
                                      std::span<const SurfaceSample> samples);

/// Points inside a mesh's large triangles, where its positions would miss deviations: one for every two mean
/// triangle areas, in a small mesh for every half.
std::vector<SurfaceSample> samplesInside(const NodeMesh& mesh);

}  // namespace lode::ingest
