#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// The angle at which faces that share an edge are no longer shaded as one surface.
struct CreaseAngle {
  /// @param degrees  0 to 180; 180: there are no creases.
  explicit CreaseAngle(double degrees) noexcept;

  /// Whether two faces are shaded as one, by their unit normals; false if one has none.
  bool isSmooth(glm::vec3 a, glm::vec3 b) const noexcept { return has_none || glm::dot(a, b) >= cosine; }

  bool has_none;
  float cosine, cosine_of_half;
};

/// The triangles around each position, in groups that have one normal there: two that share an edge of the
/// position belong to one fan unless the edge is a crease. So a crease that ends at a position leaves it
/// whole.
struct NormalFans {
  std::vector<uint32_t> first;      ///< the first fan of each position, and the end
  std::vector<uint32_t> of_corner;  ///< a fan; three a triangle
  std::vector<glm::i64vec3> sums;   ///< a fan's: of its triangles' cross products, see sumNormals()
};
NormalFans findFans(const NodeMesh& mesh, const CreaseAngle& crease);

/// What a leaf tells of a fan at a position that it may share with others: its sum, and the faces at which it
/// may go on there. A fan with more than two of these is told of several times, its sum once.
struct ListedFan {
  static constexpr uint16_t kMaxEnds = 2;

  uint32_t leaf = 0;
  uint16_t fan = 0;  ///< its number among those of the position in the leaf
  uint16_t ends = 0;
  glm::i64vec3 sum{0};
  PositionCode other[kMaxEnds];     ///< the other end of the edge
  glm::vec3 direction[kMaxEnds]{};  ///< of the face's normal
};
static_assert(sizeof(ListedFan) == 72);

/// Lists the fans of some positions. @param positions  rising. @return one list a position; `leaf` is left
/// open.
std::vector<std::vector<ListedFan>> listFans(const NodeMesh& mesh, const NormalFans& fans,
                                             std::span<const uint32_t> positions);

/// The normals of one position's fans after those of all leaves were joined: one a listing. Whatever leaves
/// shared the triangles out among them, the fans at a manifold are the same.
/// @param listed  leaf by leaf, each in listFans()' order.
std::vector<uint16_t> joinFans(std::span<const ListedFan> listed, const CreaseAngle& crease);

}  // namespace lode::ingest
