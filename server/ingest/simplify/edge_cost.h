#pragma once

#include <cstdint>
#include <vector>

#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/quadric.h"
#include "server/ingest/simplify/wedge_quadrics.h"

namespace lode::ingest {

/// An edge is at a hub if its two ends together have more triangles than this.
constexpr uint32_t kHubTriangles = 256;

/// Evaluates the cost of edge collapses: where the merged position goes, and what it costs. Bounds the time
/// spent around hubs. Not thread safe.
class EdgeCost {
 public:
  struct Candidate {
    Placement placement;
    bool possible = false;
    double breadth = 1;  ///< result of breadth()
  };

  /// @param mesh, attributes  must outlive this object.
  EdgeCost(CollapseMesh& mesh, WedgeQuadrics& attributes);

  /// Places the position into which an edge would collapse, and computes the cost.
  Candidate evaluate(uint32_t u, uint32_t v);
  /// Returns the sum of the quadrics at both ends of the edge that was evaluated last.
  const Quadric& quadric() const noexcept { return quadric_; }
  /// Returns true if the limit on checked triangles allows a check of all triangles around both ends of an
  /// edge. Counts these triangles towards the limit.
  bool mayLookAround(uint32_t u, uint32_t v);

 private:
  Candidate place(uint32_t u, uint32_t v);
  double breadth(uint32_t u, uint32_t v) const noexcept;
  void reduceWedges(Quadric& q, uint32_t u, uint32_t v);

  CollapseMesh& mesh_;
  WedgeQuadrics& attributes_;
  Quadric quadric_;
  std::vector<WedgeTable::Pair> pairs_;  ///< buffer that is reused between calls
  uint64_t looks_left_;  ///< number of triangles that further collapses may check; see kLooksPerTriangle
};

}  // namespace lode::ingest
