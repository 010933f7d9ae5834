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

/// The places of a model's surface that a view and its margin see, as far as a cut can tell: it is drawn here
/// into a small picture, and each of its pixels is one place. What has none, or few, is behind other parts or
/// too small to matter. Decides the order of requests alone, so that a mistake delays and leaves no hole.
class SeenPlaces {
 public:
  /// Cuts of more than that would take too long to draw.
  static constexpr uint64_t kMostTriangles = 1u << 16;

  /// By a cut's own view. @param cut  of at most kMostTriangles. @param model  what it is of.
  /// @return nothing if the cut's triangles are so large that it would take too long all the same.
  static std::optional<SeenPlaces> of(const Cut& cut, const ModelSummary& model);

  /// True if more than a few of the places lie in the node's cell.
  bool in(NodeKey node) const noexcept;

 private:
  SeenPlaces() = default;

  std::vector<NodeKey> places_;  // cells of kMaxDepth, in order
  size_t few_ = 0;
};

}  // namespace lode::core
