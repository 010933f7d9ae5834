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

/// Occlusion estimate: the octree cells that a view and its margin see. Rasterises a cut into a small depth
/// buffer; each pixel marks one cell. A node with no or few marked cells is hidden or too small to matter.
/// The estimate changes only the order of requests, so an error delays a request but never leaves a hole.
class SeenPlaces {
 public:
  /// Larger cuts would take too long to rasterise.
  static constexpr uint64_t kMostTriangles = 1u << 16;

  /// Rasterises a cut for its own view. @param cut  at most kMostTriangles.
  /// @return nothing if the triangles cover so many pixels that it would take too long.
  static std::optional<SeenPlaces> of(const Cut& cut, const ModelSummary& model);

  /// Returns true if the node's cell contains more than a few of the marked cells.
  bool in(NodeKey node) const noexcept;

 private:
  SeenPlaces() = default;

  std::vector<NodeKey> places_;  // cells at kMaxDepth, sorted
  size_t few_ = 0;
};

}  // namespace lode::core
