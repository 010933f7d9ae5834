#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/edge_surroundings.h"

namespace lode::ingest {

/// Limits on the harm that a collapse may do to the surrounding mesh. With any limits, a watertight mesh
/// stays watertight.
struct CollapseLimits {
  double least_cosine = 0;  ///< least allowed cosine of the angle between a triangle's old and new normal
  /// Least allowed ratio of a triangle's height to its longest side; checked if a triangle becomes thinner.
  double least_shape = 0;
  bool link_condition = true;     ///< true rejects collapses that make a manifold surface non-manifold
  uint32_t most_triangles = ~0u;  ///< largest allowed number of triangles around both ends
};

/// Result of a check.
struct CollapseFinding {
  bool allowed = false;  ///< the collapse is within the limits
  bool folds = false;  ///< the collapse leaves pairs of triangles with equal corners and opposite orientation
  double folded_area = 0;  ///< sum over these pairs: twice the area of one of the triangles
};

/// Checks edge collapses of a mesh. Does not change the mesh.
class CollapseCheck {
 public:
  explicit CollapseCheck(const CollapseMesh& mesh) : mesh_(mesh), marks_(mesh.positions.size(), 0) {}

  /// Checks a collapse that moves both ends of an edge to the point `to`.
  CollapseFinding check(const EdgeSurroundings& around, glm::dvec3 to, const CollapseLimits& limits);

 private:
  bool keepsShapes(const EdgeSurroundings& around, glm::dvec3 to, const CollapseLimits& limits) const;
  double areaOf(uint32_t u, uint32_t a, uint32_t b) const;
  /// Returns true if one of `sides` has the same two ends as `side`.
  bool hasSide(std::span<const EdgeSurroundings::Side> sides, EdgeSurroundings::Side side);

  /// A check marks each apex of the edge (EdgeSurroundings::apexes()) with stamp_ + kApex, and each other
  /// neighbour of u with stamp_.
  static constexpr uint32_t kApex = 1;
  static constexpr uint32_t kMarks = 2;
  static constexpr size_t kFewSides = 16;  ///< number of sides up to which hasSide() compares one by one

  const CollapseMesh& mesh_;
  std::vector<uint32_t> marks_;
  std::vector<uint64_t> ends_of_u_;  ///< sorted ends of u's sides; buffer that is reused between calls
  uint32_t stamp_ = 0;  ///< smallest mark of the current check; smaller marks belong to earlier checks
};

}  // namespace lode::ingest
