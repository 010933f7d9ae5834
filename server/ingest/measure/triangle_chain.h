#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/ingest/mesh/segment_distance.h"

namespace lode::ingest {

/// Triangles of a surface of which each has an edge in common with the next.
struct TriangleChain {
  static constexpr size_t kMostEdges = 6;

  FourSegments eachTwice(size_t edge, size_t other) const noexcept {
    return {FourVectors(from[edge], from[edge], from[other], from[other]),
            FourVectors(to[edge], to[edge], to[other], to[other])};
  }

  std::array<uint32_t, kMostEdges + 1> triangles;
  std::array<Four, kMostEdges> from, to;  ///< ends of the edges between a triangle and the next
  size_t edge_count = 0;
};

}  // namespace lode::ingest
