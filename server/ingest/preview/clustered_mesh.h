#pragma once

#include <cstdint>

#include "common/mesh.h"
#include "server/ingest/preview/cluster_grid.h"
#include "server/ingest/preview/texture_colours.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

/// Limits of a clustered mesh.
struct ClusterLimits {
  uint32_t cells = 1u << 16;
  uint32_t triangles = 500'000;
};

struct ClusteredMesh {
  Mesh mesh;
  uint32_t cell_steps = 1;  ///< width of the cells, in lattice steps

  /// Returns an upper bound on the distance between the mesh and the snapped input, in lattice steps: the
  /// length of a cell's diagonal.
  double errorSteps() const noexcept;
};

/// Simplifies a whole model by clustering: all vertices of a grid cell become one vertex, at the minimum of
/// the quadrics of the triangles that touch the cell. Reads vertices and faces sequentially, and keeps
/// ClusterGrid::kVertexBytes per vertex in memory. Keeps a triangle with corners in only one or two cells
/// unless other triangles cover these cells, so that thin and small pieces remain. The mesh has no texture
/// coordinates and no materials; its colours include those of the textures. Deterministic.
/// @param input    must be flushed and have its grid for texture coordinates.
/// @param extent   largest lattice coordinates.
/// Source: Lindstrom, Out-of-Core Simplification of Large Polygonal Models, 2000.
ClusteredMesh clusterInput(const PackedInput& input, const Lattice& lattice, glm::uvec3 extent,
                           const TextureColours& textures = {}, const ClusterLimits& limits = {});

}  // namespace lode::ingest
