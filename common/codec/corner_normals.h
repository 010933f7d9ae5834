#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/mesh.h"

namespace lode {

/// The normals of a mesh's vertices, to be found again in a mesh of the same triangles whose vertices are
/// others: Draco orders them anew, and parts one whose triangles do not hang together.
class CornerNormals {
 public:
  explicit CornerNormals(const Mesh& mesh);

  /// @param mesh  its triangles, by their positions and their sides, are those of the one before.
  /// @return a code a vertex; nothing where equal triangles have different normals.
  std::optional<std::vector<uint16_t>> ofVertices(const Mesh& mesh) const;

 private:
  struct OfPosition {
    PositionCode position;
    uint16_t normal = 0;
    bool is_taken = false, has_several = false;
  };
  /// Of a triangle, at a position that has several normals.
  struct OfCorner {
    PositionCode position, next, last;
    uint16_t normal = 0;
    auto operator<=>(const OfCorner&) const = default;
  };
  /// The place of a position in the table, or where it would be.
  size_t placeOf(PositionCode position) const noexcept;
  /// The only one there; nothing where there are several.
  std::optional<uint16_t> at(PositionCode position) const;
  std::optional<uint16_t> at(const OfCorner& corner) const;
  static OfCorner cornerOf(const Mesh& mesh, glm::u32vec3 triangle, int corner);

  std::vector<OfPosition> positions_;  ///< by open addressing
  std::vector<OfCorner> corners_;      ///< each once, rising
};

}  // namespace lode
