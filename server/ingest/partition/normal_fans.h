#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// The crease angle. An edge is shaded as sharp if its two faces meet at a larger angle.
struct CreaseAngle {
  /// @param degrees  angle from 0 to 180; at 180 no edge is sharp.
  explicit CreaseAngle(double degrees) noexcept;

  /// Returns true if the edge between faces with two unit normals is smooth. An edge of a face with a zero
  /// normal is sharp, unless the angle makes no edge sharp.
  bool isSmooth(glm::vec3 a, glm::vec3 b) const noexcept { return has_none || glm::dot(a, b) >= cosine; }

  bool has_none;
  float cosine, cosine_of_half;
};

/// Triangles around each position, grouped into fans with one normal each. Two triangles that share an edge
/// at the position are in one fan unless the edge is sharp. A single sharp edge that ends at the position
/// does not split the fan.
struct NormalFans {
  /// Index of each position's first fan; the last element is the number of fans.
  std::vector<uint32_t> first;
  std::vector<uint32_t> of_corner;  ///< fan of each corner; three per triangle
  /// For each fan, the sum of its triangles' cross products, see sumNormals().
  std::vector<glm::i64vec3> sums;
};
NormalFans findFans(const NodeMesh& mesh, const CreaseAngle& crease);

/// A fan of a leaf at a border position, with the sum of its cross products and with its ends. An end is a
/// face at which the fan can continue in another leaf. A fan with more than two ends has several entries;
/// only the first entry has the sum.
struct ListedFan {
  static constexpr uint16_t kMaxEnds = 2;

  uint32_t leaf = 0;
  uint16_t fan = 0;  ///< index among the leaf's fans at this position
  uint16_t ends = 0;
  glm::i64vec3 sum{0};
  PositionCode other[kMaxEnds];     ///< for each end, the other vertex of the edge at which the fan ends
  glm::vec3 direction[kMaxEnds]{};  ///< for each end, the unit normal of its face
};
static_assert(sizeof(ListedFan) == 72);

/// Lists the fans of some positions. @param positions  positions in ascending order. @return one list per
/// position; `leaf` is not set.
std::vector<std::vector<ListedFan>> listFans(const NodeMesh& mesh, const NormalFans& fans,
                                             std::span<const uint32_t> positions);

/// Joins one position's fans of all leaves and returns the normal of each entry. On manifolds the result does
/// not depend on how the triangles are divided among leaves.
/// @param listed  fans sorted by leaf, and within a leaf in the order of listFans().
std::vector<uint16_t> joinFans(std::span<const ListedFan> listed, const CreaseAngle& crease);

}  // namespace lode::ingest
