#pragma once

#include <compare>
#include <span>
#include <vector>

#include "common/mesh.h"

namespace lode::store {

/// An edge by its positions, a < b.
struct OpenEdge {
  PositionCode a, b;

  friend auto operator<=>(const OpenEdge&, const OpenEdge&) = default;
};

/// Collects the edges that are used by an odd number of triangles, over any number of meshes. What lies
/// inside a mesh cancels at once and what neighbours share soon after, so that memory goes with the open
/// part. Not thread safe.
class OpenEdges {
 public:
  void add(const Mesh& mesh);
  /// @param open  the open edges of one mesh or several.
  void add(std::span<const OpenEdge> open);
  /// All open edges so far, sorted by position.
  const std::vector<OpenEdge>& edges();

 private:
  std::vector<OpenEdge> pending_;
  size_t cancel_at_ = 1u << 16;
};

}  // namespace lode::store
