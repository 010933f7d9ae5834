#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "server/ingest/mesh/segment_distance.h"

namespace lode::ingest {

/// Triangles of a surface of which each has an edge in common with the next.
struct TriangleChain {
  static constexpr size_t kMostEdges = 6;

  /// Four edges; what there is not is the last again.
  FourSegments edgesFrom(size_t first) const noexcept {
    const auto at = [&](size_t i) { return std::min(first + i, edge_count - 1); };
    const auto four = [&](const std::array<Four, kMostEdges>& ends) {
      return FourVectors(ends[at(0)], ends[at(1)], ends[at(2)], ends[at(3)]);
    };
    return {four(from), four(to)};
  }

  std::array<uint32_t, kMostEdges + 1> triangles;
  std::array<Four, kMostEdges> from, to;  ///< ends of the edges between a triangle and the next
  size_t edge_count = 0;
};

}  // namespace lode::ingest
