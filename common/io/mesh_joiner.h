#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/mesh.h"

namespace lode {

/// Puts the parts of a cut together into one mesh: vertices equal in position and attributes become one.
/// Vertices and triangles come in the order of the parts. Not thread safe.
class MeshJoiner {
 public:
  /// @param triangles  to make room for.
  MeshJoiner(AttributeSet attributes, uint64_t triangles);

  /// @throws Error kLimit if the whole has more vertices than an index can name.
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
  std::vector<uint32_t> renumbered_;  ///< of the part that is added
};

}  // namespace lode
