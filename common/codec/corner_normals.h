#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/mesh.h"

namespace lode {

/// Transfers the normals of a mesh to a mesh with the same triangles but different vertices. Draco's decoder
/// returns such a mesh, because the encoder reorders vertices and splits non-manifold vertices.
class CornerNormals {
 public:
  explicit CornerNormals(const Mesh& mesh);

  /// Returns the normal code of each vertex of `mesh`, or nothing if the original mesh has equal triangles
  /// with different normals.
  /// @param mesh  a mesh with the triangles of the original mesh, in the same orientation.
  std::optional<std::vector<uint16_t>> ofVertices(const Mesh& mesh) const;

 private:
  struct OfPosition {
    PositionCode position;
    uint16_t normal = 0;
    bool is_taken = false, has_several = false;
  };
  /// A corner of a triangle, with its normal. Used only at positions that have several normals.
  struct OfCorner {
    PositionCode position, next, last;
    uint16_t normal = 0;
    auto operator<=>(const OfCorner&) const = default;
  };
  /// Returns the slot of a position in the hash table, or the empty slot for a new position.
  size_t placeOf(PositionCode position) const noexcept;
  /// Returns the normal of a position if the position has exactly one normal.
  std::optional<uint16_t> at(PositionCode position) const;
  std::optional<uint16_t> at(const OfCorner& corner) const;
  static OfCorner cornerOf(const Mesh& mesh, glm::u32vec3 triangle, int corner);

  std::vector<OfPosition> positions_;  ///< hash table with open addressing
  std::vector<OfCorner> corners_;      ///< sorted corners without duplicates
};

}  // namespace lode
