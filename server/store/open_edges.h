#pragma once

#include <compare>
#include <span>
#include <vector>

#include "common/mesh.h"

namespace lode::store {

/// An edge as its two end positions, a < b.
struct OpenEdge {
  PositionCode a, b;

  friend auto operator<=>(const OpenEdge&, const OpenEdge&) = default;
};

/// Collects the edges that an odd number of triangles has, over any number of meshes. Edges inside a mesh
/// cancel immediately, and edges that neighbouring meshes share cancel soon, so the memory is proportional to
/// the number of open edges. Not thread safe.
class OpenEdges {
 public:
  void add(const Mesh& mesh);
  /// Adds open edges of one or more meshes.
  void add(std::span<const OpenEdge> open);
  /// Returns all open edges so far, sorted.
  const std::vector<OpenEdge>& edges();

 private:
  std::vector<OpenEdge> pending_;
  size_t cancel_at_ = 1u << 16;
};

}  // namespace lode::store
