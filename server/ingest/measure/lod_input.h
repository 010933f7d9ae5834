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

/// Number of exhaustive searches that cost as much as building a tree.
constexpr int kMostSearchesOfInput = 32;

/// The mesh from which a node's LODs are made, and to which they are compared. Const functions are thread
/// safe.
class LodInput {
 public:
  /// @param depth  depth of the node; positions that are locked at this depth lie on the node's borders.
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
  /// Number of references. The given references come first, then the boundary edges that are their own
  /// reference.
  uint32_t referenceCount() const noexcept {
    return static_cast<uint32_t>(references_.boundaries.size()) + own_;
  }
  ReferenceBoundary reference(uint32_t number) const noexcept;
  float referenceGapSteps() const noexcept { return references_.gap_steps; }
  /// Returns a search tree of the mesh. The first call builds the tree, because few nodes need one.
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

/// Maps both ends of a boundary edge.
glm::u32vec2 imageOf(glm::u32vec2 ends, std::span<const uint32_t> remap) noexcept;

/// Returns the references of an LOD that replaces its input. These are the input's references, except
/// vanished references. If there are more than `most` references, the LOD's own boundary edges replace them.
/// @param boundary_gap_steps  gap of the LOD's boundaries; see boundaryGap()
ReferenceBoundaries referencesIn(const LodInput& input, std::span<const uint32_t> remap,
                                 float boundary_gap_steps, size_t most);

}  // namespace lode::ingest
