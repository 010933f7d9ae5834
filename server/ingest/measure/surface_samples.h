#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/ingest/measure/lod_surface.h"
#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// A point of the original surface, with its distance from the current mesh in lattice steps. Nodes pass
/// their samples to their parents.
struct SurfaceSample {
  PositionCode position;
  /// Distance from the current mesh; too large by at most a quarter of the mesh's largest deviation.
  float deviation = 0;
  /// Position of the current mesh that the point maps to, or a nearby position if that one has no triangles
  /// left.
  uint32_t near = kVanished;
};

/// Thins out samples to `capacity`, without changing their order. Of all samples with the same `near`, always
/// keeps the one with the largest deviation, so that every piece of the mesh has a sample. Fills the
/// remaining capacity with the samples that deviate most.
/// @param positions  number of positions in the mesh.
void selectSamples(std::vector<SurfaceSample>& samples, size_t positions, size_t capacity);

/// Adds a sample at each locked position of a node's coarsest mesh, that is, at each position on the node's
/// borders. Locked positions have never moved, so they are points of the original, even if all samples near
/// them were dropped. @param depth  depth of the node.
void addLockedPositions(std::vector<SurfaceSample>& samples, const NodeMesh& mesh, int depth);

/// Removes duplicates: keeps only the sample with the largest deviation among those with equal `position` and
/// `near`. Sorts the samples by position.
void dropDuplicates(std::vector<SurfaceSample>& samples);

/// Returns, for each position of an LOD's input, its place on the LOD; undefined for vanished positions.
/// @param walk  a walk over the LOD's mesh.
std::vector<SurfaceWalk::Place> placesOn(const SimplifiedMesh& lod, const NodeMesh& input,
                                         const SurfaceWalk& walk);

/// Distance of a sample from an LOD, in lattice steps.
struct Deviation {
  float steps;
  uint32_t near;  ///< position of the LOD to which the sample maps; see SurfaceSample::near
};

/// Measures the distances of samples from an LOD. The largest distance is exact; the others are upper bounds.
/// @param surface  the LOD's surface. @param places  see placesOn(). @param samples  samples whose `near` are
/// positions of the input.
std::vector<Deviation> deviationsFrom(const SimplifiedMesh& lod, const NodeMesh& input,
                                      const LodSurface& surface, std::span<const SurfaceWalk::Place> places,
                                      std::span<const SurfaceSample> samples);

/// Returns points inside a mesh's large triangles, because vertices alone would miss deviations there. A
/// triangle gets one point per two mean triangle areas, in a small mesh one point per half of the mean area.
std::vector<SurfaceSample> samplesInside(const NodeMesh& mesh);

}  // namespace lode::ingest
