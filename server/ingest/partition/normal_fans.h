#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Angle beyond which an edge between two faces is shaded as sharp.
struct CreaseAngle {
  /// @param degrees  0 to 180; 180: no edge is sharp.
  explicit CreaseAngle(double degrees) noexcept;

  /// Returns whether the edge between faces with these unit normals is smooth; false for a zero normal.
  bool isSmooth(glm::vec3 a, glm::vec3 b) const noexcept { return has_none || glm::dot(a, b) >= cosine; }

  bool has_none;
  float cosine, cosine_of_half;
};

/// Triangles around each position, grouped into fans with one normal each. Two triangles that share an edge
/// at the position are in one fan unless the edge is sharp. A sharp edge that ends at a position does not
/// split its fan.
struct NormalFans {
  std::vector<uint32_t> first;      ///< first fan of each position, and the end
  std::vector<uint32_t> of_corner;  ///< fan of each corner; three per triangle
  std::vector<glm::i64vec3> sums;   ///< per fan: sum of cross products, see sumNormals()
};
NormalFans findFans(const NodeMesh& mesh, const CreaseAngle& crease);

/// A leaf's fan at a border position: its sum, and its ends, which are faces where it may continue in another
/// leaf. A fan with more than two ends has several entries; only the first has the sum.
struct ListedFan {
  static constexpr uint16_t kMaxEnds = 2;

  uint32_t leaf = 0;
  uint16_t fan = 0;  ///< index among the fans of the position in the leaf
  uint16_t ends = 0;
  glm::i64vec3 sum{0};
  PositionCode other[kMaxEnds];     ///< far vertex of the end's edge
  glm::vec3 direction[kMaxEnds]{};  ///< unit normal of the end's face
};
static_assert(sizeof(ListedFan) == 72);

/// Lists the fans of some positions. @param positions  rising. @return one list per position, without `leaf`.
std::vector<std::vector<ListedFan>> listFans(const NodeMesh& mesh, const NormalFans& fans,
                                             std::span<const uint32_t> positions);

/// Joins one position's fans of all leaves and returns the normal of each entry. On manifolds the result does
/// not depend on how the triangles are divided among leaves.
/// @param listed  sorted by leaf, each leaf's in the order of listFans().
std::vector<uint16_t> joinFans(std::span<const ListedFan> listed, const CreaseAngle& crease);

}  // namespace lode::ingest
