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

/// A boundary of the original that travels up the tree, for boundaries to be measured against.
struct ReferenceBoundary {
  PositionCode from, to;
  glm::u32vec2 near;  ///< what has become of its ends in the mesh at hand: positions, or kVanished
};

/// What the boundaries of a mesh are measured against. One that is the image of none of these stands for
/// itself.
struct ReferenceBoundaries {
  std::vector<ReferenceBoundary> boundaries;
  float gap_steps =
      0;  ///< what none of all these is farther from a boundary of the original, in lattice steps
};

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

/// What has become of both ends of a boundary.
glm::u32vec2 imageOf(glm::u32vec2 ends, std::span<const uint32_t> became) noexcept;

/// What the boundaries of an LOD are measured against where it takes its input's place: what the input's are,
/// but for what has vanished; or the LOD's own boundaries, if that is more than `most`.
/// @param boundary_gap_steps  the LOD's, see boundaryGap()
ReferenceBoundaries referencesIn(const LodInput& input, std::span<const uint32_t> became,
                                 float boundary_gap_steps, size_t most);

}  // namespace lode::ingest
