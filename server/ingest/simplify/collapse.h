#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

struct CollapseOptions {
  int node_depth = 0;                    ///< positions with lca_depth < node_depth are locked
  glm::uvec3 max_position{kMaxLattice};  ///< optima are clamped to 0..max_position, the model's box
  double attribute_weight = 1;  ///< weight of the file's attributes against geometry; 0: geometry only
};

/// Receives a compacted mesh for each triangle count that was reached, in order of `targets`. If no further
/// collapse is possible before the last target, the sink is called once more with the mesh so far.
using SnapshotSink = std::function<void(size_t target_index, SimplifiedMesh&& snapshot)>;

/// Simplifies a node's mesh by edge collapses in order of quadric error; one sequence yields all LODs.
///
/// Simplification maps positions to positions; locked positions map to themselves and do not move. A triangle
/// disappears only if two of its corners coincide, or together with an opposite triangle, so boundary edges
/// map to boundary edges (I2). Boundary edges add quadrics that keep them in place. Seams (edges at which
/// attributes differ between two triangles) collapse along themselves, not across. The file's normals,
/// colours and texture coordinates are part of the quadrics (see wedge_quadrics.h); attributes of locked
/// positions stay. Positions are rounded to the lattice. Deterministic, stateless, thread safe.
/// @param targets  triangle counts, descending.
/// Sources: Garland & Heckbert, Surface Simplification Using Quadric Error Metrics, 1997; Simplifying
/// Surfaces with Color and Texture using Quadric Error Metrics, 1998; Hoppe, New Quadric Metric, 1999.
void collapse(NodeMesh mesh, std::span<const size_t> targets, const CollapseOptions& options,
              const SnapshotSink& sink);

}  // namespace lode::ingest
