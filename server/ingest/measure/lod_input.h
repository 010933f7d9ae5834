#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "server/ingest/measure/reference_boundaries.h"
#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/measure/triangle_tree.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

constexpr int kMostLooksAtInput = 32;  ///< at every triangle, before the tree is worth its making

/// What the LODs of a node are made of and measured against. Const functions are thread safe.
class LodInput {
 public:
  /// @param depth  the node's: positions that are locked there lie on its borders.
  /// @param off_steps  what the mesh is off the original by; none if it is the original.
  /// @param references  near positions of the mesh.
  LodInput(NodeMesh mesh, int depth, std::optional<float> off_steps = {},
           ReferenceBoundaries references = {});

  const NodeMesh& mesh() const noexcept { return mesh_; }
  const SurfaceWalk& walk() const noexcept { return walk_; }
  bool isOriginal() const noexcept { return !off_steps_; }
  float offSteps() const noexcept { return off_steps_.value_or(0); }
  /// Open edges, by position; borders of the node are none.
  const std::vector<glm::u32vec2>& boundaries() const noexcept { return boundaries_; }
  /// What the boundaries are measured against: the references, and behind them boundaries that stand for
  /// themselves.
  uint32_t referenceCount() const noexcept {
    return static_cast<uint32_t>(references_.boundaries.size()) + own_;
  }
  ReferenceBoundary reference(uint32_t number) const noexcept;
  float referenceGapSteps() const noexcept { return references_.gap_steps; }
  /// Made when it is first asked for: few nodes need it.
  const TriangleTree& tree() const;

 private:
  NodeMesh mesh_;
  SurfaceWalk walk_;
  std::optional<float> off_steps_;
  ReferenceBoundaries references_;
  std::vector<glm::u32vec2> boundaries_;  ///< first those that stand for themselves
  uint32_t own_ = 0;                      ///< how many do
  mutable std::once_flag tree_made_;
  mutable std::optional<TriangleTree> tree_;
};

}  // namespace lode::ingest
