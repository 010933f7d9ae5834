#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

struct CollapseOptions {
  /// Depth of the node; positions with lca_depth < node_depth are locked, that is, may not move.
  int node_depth = 0;
  /// Upper corner of the model's box; optima are clamped to 0..max_position.
  glm::uvec3 max_position{kMaxLattice};
  /// Weight of the file's attributes relative to geometry; 0 ignores attributes.
  double attribute_weight = 1;
};

/// Receives a compacted mesh for each target triangle count, in the order of the targets. If a target cannot
/// be reached, receives the smallest possible mesh for this target, and nothing for later targets.
using SnapshotSink = std::function<void(size_t target_index, SimplifiedMesh&& snapshot)>;

/// Simplifies a node's mesh by edge collapses in order of quadric error. One sequence of collapses yields all
/// LODs. If too few edges can collapse, continues with cluster().
///
/// Simplification maps positions to positions. Locked positions, which the node shares with other nodes, map
/// to themselves and do not move. A triangle disappears only if two of its corners coincide, or together with
/// a triangle of opposite orientation. Therefore boundary edges map to boundary edges (I2 in
/// docs/architecture.md). Boundary edges add quadrics that keep them in place. Seams, which are edges with
/// different attributes in their two triangles, collapse along themselves, not across. The quadrics include
/// the file's normals, colours and texture coordinates (see wedge_quadrics.h). Locked positions keep their
/// attributes. Positions are rounded to the lattice. Deterministic, stateless, thread safe.
/// @param targets  triangle counts, descending.
/// Sources: Garland & Heckbert, Surface Simplification Using Quadric Error Metrics, 1997; Simplifying
/// Surfaces with Color and Texture using Quadric Error Metrics, 1998; Hoppe, New Quadric Metric, 1999.
void collapse(NodeMesh mesh, std::span<const size_t> targets, const CollapseOptions& options,
              const SnapshotSink& sink);

}  // namespace lode::ingest
