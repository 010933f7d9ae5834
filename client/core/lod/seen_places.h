#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "client/core/lod/cut.h"
#include "common/codec/model_summary.h"
#include "common/node_key.h"

namespace lode::core {

/// Estimates occlusion: lists the octree cells that are visible in a view and its margin. Rasterises a cut
/// into a small depth buffer, in which each pixel marks one cell. A node with few marked cells counts as
/// occluded: the node is hidden or too small to matter. The estimate changes only the order of requests, so
/// an error delays a request but never leaves a hole.
class SeenPlaces {
 public:
  /// Largest number of triangles of a cut. Larger cuts would take too long to rasterise.
  static constexpr uint64_t kMostTriangles = 1u << 16;

  /// Rasterises a cut for its own view. @param cut  cut with at most kMostTriangles triangles.
  /// @return nothing if rasterising would test too many pixels.
  static std::optional<SeenPlaces> of(const Cut& cut, const ModelSummary& model);

  /// Returns true if the node contains enough marked cells to count as visible.
  bool in(NodeKey node) const noexcept;

 private:
  SeenPlaces() = default;

  std::vector<NodeKey> places_;  // marked cells at kMaxDepth, sorted; one entry per pixel
  size_t few_ = 0;
};

}  // namespace lode::core
