#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/simplify/collapse_mesh.h"

namespace lode::ingest {

/// How much a collapse may harm the mesh around it. Each level allows more; what is watertight stays so at
/// all.
struct CollapseLimits {
  double least_cosine = 0;        ///< between a triangle's old and new normal
  double least_shape = 0;         ///< height over longest side of triangles that lose shape
  bool link_condition = true;     ///< the surface stays a manifold where it is one
  uint32_t most_triangles = ~0u;  ///< around both ends
};

/// What a collapse would do.
struct CollapseFinding {
  uint32_t removed = 0;    ///< triangles of the edge; 0: the edge is no longer there
  bool allowed = false;    ///< by the limits
  bool folds = false;      ///< identical triangles come to lie on each other
  double folded_area = 0;  ///< twice the area of one side of those
};

/// Looks at collapses of edges of a mesh, without changing it.
class CollapseCheck {
 public:
  explicit CollapseCheck(const CollapseMesh& mesh) : mesh_(mesh), marks_(mesh.positions.size(), 0) {}

  /// @param to  where u and v would go; may be the place of one of them
  CollapseFinding look(uint32_t u, uint32_t v, glm::dvec3 to, const CollapseLimits& limits);

 private:
  bool keepsShape(uint32_t corner, glm::dvec3 from, glm::dvec3 to, const CollapseLimits& limits) const;
  double areaOfOthers(uint32_t u, uint32_t a, uint32_t b) const;

  /// What a look adds to its stamp where it marks more than a neighbour of u.
  static constexpr uint32_t kCounted = 1;  ///< a neighbour of v too
  static constexpr uint32_t kApex = 2;     ///< of the edge
  static constexpr uint32_t kMarks = 3;

  const CollapseMesh& mesh_;
  std::vector<uint32_t> marks_;
  uint32_t stamp_ = 0;  ///< of the look at hand; marks below it are of earlier ones
};

}  // namespace lode::ingest
