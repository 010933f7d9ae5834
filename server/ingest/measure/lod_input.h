#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/measure/triangle_tree.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// A boundary edge of the original mesh, or of a finer LOD, that is kept as a reference: the boundary edges
/// of coarser LODs are compared with it.
struct ReferenceBoundary {
  PositionCode from, to;  ///< ends of the edge
  glm::u32vec2 near;      ///< positions in the current mesh to which the ends map, or kVanished
};

/// The references with which the boundary edges of a mesh are compared. A boundary edge to which no reference
/// maps is compared with itself.
struct ReferenceBoundaries {
  std::vector<ReferenceBoundary> boundaries;
  /// Upper bound on the distance from these references to the original boundary, in lattice steps.
  float gap_steps = 0;
};

/// Largest number of searches that test all triangles of the input. Together they cost as much as building a
/// TriangleTree, which later searches use.
constexpr int kMostSearchesOfInput = 32;

/// The mesh from which a node's LODs are made, and with which they are compared. Const functions are thread
/// safe.
class LodInput {
 public:
  /// @param depth  depth of the node; positions with a smaller lca_depth (see NodeMesh) lie on the node's
  /// borders and are locked.
  /// @param off_steps  deviation of the mesh from the original, in lattice steps; empty if the mesh is the
  /// original.
  /// @param references  references whose `near` are positions in the mesh.
  LodInput(NodeMesh mesh, int depth, std::optional<float> off_steps = {},
           ReferenceBoundaries references = {});

  const NodeMesh& mesh() const noexcept { return mesh_; }
  const SurfaceWalk& walk() const noexcept { return walk_; }
  bool isOriginal() const noexcept { return !off_steps_; }
  float offSteps() const noexcept { return off_steps_.value_or(0); }
  /// Returns the boundary edges: all open edges except those on the node's borders, each a pair of positions.
  const std::vector<glm::u32vec2>& boundaries() const noexcept { return boundaries_; }
  /// Returns the number of references. The references that were passed to the constructor have the first
  /// numbers. The boundary edges that are their own references follow.
  uint32_t referenceCount() const noexcept {
    return static_cast<uint32_t>(references_.boundaries.size()) + own_;
  }
  ReferenceBoundary reference(uint32_t number) const noexcept;
  float referenceGapSteps() const noexcept { return references_.gap_steps; }
  /// Returns a search tree of the mesh. Few nodes need one, so it is not built before the first call.
  const TriangleTree& tree() const;

 private:
  NodeMesh mesh_;
  SurfaceWalk walk_;
  std::optional<float> off_steps_;
  ReferenceBoundaries references_;
  std::vector<glm::u32vec2> boundaries_;  ///< see boundaries(); the first own_ are their own references
  uint32_t own_ = 0;                      ///< number of boundary edges that are their own references
  mutable std::once_flag tree_made_;
  mutable std::optional<TriangleTree> tree_;
};

/// Maps both ends of a boundary edge to a simplified mesh. @param remap  new position, or kVanished, for each
/// old position. An end that is kVanished stays kVanished.
glm::u32vec2 imageOf(glm::u32vec2 ends, std::span<const uint32_t> remap) noexcept;

/// Returns the references for an LOD that is itself the input of coarser LODs: the references of the mesh
/// from which the LOD was made, without those whose two ends have vanished. If more than `most` remain,
/// returns none, and the LOD's boundary edges are their own references.
/// @param input               mesh from which the LOD was made.
/// @param remap               position in the LOD, or kVanished, for each position in `input`.
/// @param boundary_gap_steps  distance of the LOD's boundary edges from the original boundary; see
///                            boundaryGap().
ReferenceBoundaries referencesIn(const LodInput& input, std::span<const uint32_t> remap,
                                 float boundary_gap_steps, size_t most);

}  // namespace lode::ingest
