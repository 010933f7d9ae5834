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

/// A boundary edge of the original, kept as a reference for the boundaries of coarser meshes.
struct ReferenceBoundary {
  PositionCode from, to;
  glm::u32vec2 near;  ///< positions of the current mesh to which the ends of the edge map, or kVanished
};

/// References of a mesh's boundary edges. If no reference maps to a boundary edge, the edge is its own
/// reference.
struct ReferenceBoundaries {
  std::vector<ReferenceBoundary> boundaries;
  /// Upper bound on the distance from these references to the original boundary, in lattice steps.
  float gap_steps = 0;
};

/// Largest number of searches that test all triangles of the input. Together they cost as much as building a
/// TriangleTree, which later searches use.
constexpr int kMostSearchesOfInput = 32;

/// The mesh that a node's LODs are made from and compared with. Const functions are thread safe.
class LodInput {
 public:
  /// @param depth  depth of the node; positions with a smaller lca_depth (see NodeMesh) lie on the node's
  /// borders and are locked.
  /// @param off_steps  deviation of the mesh from the original; empty if it is the original.
  /// @param references  references whose `near` are positions of the mesh.
  LodInput(NodeMesh mesh, int depth, std::optional<float> off_steps = {},
           ReferenceBoundaries references = {});

  const NodeMesh& mesh() const noexcept { return mesh_; }
  const SurfaceWalk& walk() const noexcept { return walk_; }
  bool isOriginal() const noexcept { return !off_steps_; }
  float offSteps() const noexcept { return off_steps_.value_or(0); }
  /// Open edges, each a pair of positions, except open edges on the node's borders.
  const std::vector<glm::u32vec2>& boundaries() const noexcept { return boundaries_; }
  /// Number of edges of the original mesh that boundary edges are measured against. Edges passed to the
  /// constructor have the smaller numbers. Boundary edges without such a reference follow, each of which is
  /// measured against itself.
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
  std::vector<glm::u32vec2> boundaries_;  ///< open edges; the first own_ of them are their own reference
  uint32_t own_ = 0;                      ///< number of boundary edges that are their own reference
  mutable std::once_flag tree_made_;
  mutable std::optional<TriangleTree> tree_;
};

/// Maps both ends of a boundary edge with `remap`. kVanished stays kVanished.
glm::u32vec2 imageOf(glm::u32vec2 ends, std::span<const uint32_t> remap) noexcept;

/// Returns the references of an LOD that becomes the next input: the references of its own input, without
/// those whose two ends have vanished. If more than `most` remain, returns none, so that the LOD's boundary
/// edges become their own references.
/// @param boundary_gap_steps  gap of the LOD's boundary edges; see boundaryGap().
ReferenceBoundaries referencesIn(const LodInput& input, std::span<const uint32_t> remap,
                                 float boundary_gap_steps, size_t most);

}  // namespace lode::ingest
