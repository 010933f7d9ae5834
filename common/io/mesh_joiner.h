#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/mesh.h"

namespace lode {

/// Joins meshes into one mesh and merges vertices that have equal positions and attributes. Vertices and
/// triangles keep the order in which add() received them. Not thread safe.
class MeshJoiner {
 public:
  /// @param triangles  expected number of triangles, to reserve memory.
  MeshJoiner(AttributeSet attributes, uint64_t triangles);

  /// @throws Error kLimit if the joined mesh exceeds 2^32 vertices.
  void add(const Mesh& part);
  Mesh finish() { return std::move(whole_); }

 private:
  struct Wedge {
    PositionCode position;
    VertexAttributes attributes;
    bool operator==(const Wedge&) const = default;
  };
  struct WedgeHash {
    size_t operator()(const Wedge& wedge) const noexcept;
  };

  Mesh whole_;
  std::unordered_map<Wedge, uint32_t, WedgeHash> numbers_;
  std::vector<uint32_t> renumbered_;  ///< new index of each vertex of the current part
};

}  // namespace lode
