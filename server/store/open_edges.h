#pragma once

#include <compare>
#include <span>
#include <vector>

#include "common/mesh.h"

namespace lode::store {

/// An edge, given by the positions of its two ends; a < b.
struct OpenEdge {
  PositionCode a, b;

  friend auto operator<=>(const OpenEdge&, const OpenEdge&) = default;
};

/// Collects the open edges of any number of meshes: the edges that an odd number of triangles use. The two
/// uses of an edge inside one mesh cancel at once; uses in different meshes cancel whenever enough edges have
/// been added. The memory is therefore proportional to the number of open edges. Not thread safe.
class OpenEdges {
 public:
  void add(const Mesh& mesh);
  /// Adds the open edges of one or more meshes.
  void add(std::span<const OpenEdge> open);
  /// Returns all open edges so far, sorted.
  const std::vector<OpenEdge>& edges();

 private:
  std::vector<OpenEdge> pending_;
  size_t cancel_at_ = 1u << 16;
};

}  // namespace lode::store
