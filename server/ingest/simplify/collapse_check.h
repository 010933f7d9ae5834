#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/edge_surroundings.h"

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
  bool allowed = false;    ///< by the limits
  bool folds = false;      ///< identical triangles come to lie on each other
  double folded_area = 0;  ///< twice the area of one side of those
};

/// Looks at collapses of edges of a mesh, without changing it.
class CollapseCheck {
 public:
  explicit CollapseCheck(const CollapseMesh& mesh) : mesh_(mesh), marks_(mesh.positions.size(), 0) {}

  /// @param to  where the ends of the edge would go; may be the place of one of them
  CollapseFinding look(const EdgeSurroundings& around, glm::dvec3 to, const CollapseLimits& limits);

 private:
  bool keepsShapes(const EdgeSurroundings& around, glm::dvec3 to, const CollapseLimits& limits) const;
  double areaOf(uint32_t u, uint32_t a, uint32_t b) const;

  /// What a look adds to its stamp where it marks more than a neighbour of u.
  static constexpr uint32_t kApex = 1;  ///< of the edge
  static constexpr uint32_t kMarks = 2;

  const CollapseMesh& mesh_;
  std::vector<uint32_t> marks_;
  uint32_t stamp_ = 0;  ///< of the look at hand; marks below it are of earlier ones
};

}  // namespace lode::ingest
