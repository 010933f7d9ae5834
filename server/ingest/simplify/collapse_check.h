#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/edge_surroundings.h"

namespace lode::ingest {

/// Limits on the damage of a collapse to the surrounding mesh. A watertight mesh stays watertight at every
/// level.
struct CollapseLimits {
  double least_cosine = 0;     ///< least cosine between the old and the new normal of a triangle
  double least_shape = 0;      ///< least ratio of height to longest side, for triangles that become thinner
  bool link_condition = true;  ///< reject collapses that make a manifold surface non-manifold
  uint32_t most_triangles = ~0u;  ///< largest number of triangles around both ends
};

/// Result of a check.
struct CollapseFinding {
  bool allowed = false;    ///< the collapse is within the limits
  bool folds = false;      ///< the collapse leaves two identical triangles of opposite orientation
  double folded_area = 0;  ///< twice the area of one triangle of each such pair, in all
};

/// Checks edge collapses of a mesh without changing it.
class CollapseCheck {
 public:
  explicit CollapseCheck(const CollapseMesh& mesh) : mesh_(mesh), marks_(mesh.positions.size(), 0) {}

  /// Checks a collapse that moves both ends of an edge to `to`, which may be one of them.
  CollapseFinding check(const EdgeSurroundings& around, glm::dvec3 to, const CollapseLimits& limits);

 private:
  bool keepsShapes(const EdgeSurroundings& around, glm::dvec3 to, const CollapseLimits& limits) const;
  double areaOf(uint32_t u, uint32_t a, uint32_t b) const;

  /// Offset from stamp_ that marks an apex of the edge instead of a plain neighbour of u.
  static constexpr uint32_t kApex = 1;
  static constexpr uint32_t kMarks = 2;

  const CollapseMesh& mesh_;
  std::vector<uint32_t> marks_;
  uint32_t stamp_ = 0;  ///< smallest mark of the current check; lower marks are from earlier checks
};

}  // namespace lode::ingest
