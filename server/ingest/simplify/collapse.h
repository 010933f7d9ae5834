#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

struct CollapseOptions {
  int node_depth = 0;                    ///< positions with lca_depth < node_depth are locked
  glm::uvec3 max_position{kMaxLattice};  ///< optima are clamped to 0..max_position (the model's box)
  double attribute_weight = 1;           ///< of the file's attributes beside positions; 0: geometry alone
};

/// Called at each triangle target that was reached, in order, and once more at the end if no more collapse is
/// possible (with fewer targets reached than asked for): the mesh so far, compacted.
using SnapshotSink = std::function<void(size_t target_index, SimplifiedMesh&& snapshot)>;

/// Simplifies a node's mesh by edge collapse in order of quadric error; one sequence yields all LODs.
///
/// A map on positions that fixes locked ones; a triangle goes only when two of its corners coincide, or
/// identical triangles in pairs, so that open edges stay the image of open edges (design I2). Boundaries
/// carry boundary quadrics. Attribute discontinuities (several wedges at a position) collapse along
/// themselves, not across. The file's normals, colours and texture coordinates are part of the quadrics (see
/// wedge_quadrics.h); a locked position's attributes stay. Vertices come to lie on the lattice.
/// Deterministic. Thread safe (no state).
/// @param targets  triangle counts, falling.
/// Sources: Garland & Heckbert, Surface Simplification Using Quadric Error Metrics, 1997; Simplifying
/// Surfaces with Color and Texture using Quadric Error Metrics, 1998; Hoppe, New Quadric Metric, 1999.
void collapse(NodeMesh mesh, std::span<const size_t> targets, const CollapseOptions& options,
              const SnapshotSink& sink);

}  // namespace lode::ingest
