#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/simplify/quadric.h"
#include "server/ingest/simplify/wedge_values.h"

namespace lode::ingest {

/// Kind of an edge. A wedge is one set of attributes at a position.
enum class EdgeKind : uint8_t {
  kSmooth,    ///< edge with two triangles that use the same wedges at both ends
  kSeam,      ///< edge with two triangles that use different wedges at one end or both
  kBoundary,  ///< edge with one triangle, or with more than two
};

/// Kind of a position. The kind follows from the feature edges (seams and boundaries) that end at the
/// position.
enum class PositionKind : uint8_t {
  kSmooth,          ///< position without feature edges
  kSeam,            ///< position on a seam: two seam edges and no boundary edge end there
  kSeamCorner,      ///< position at which a seam ends or seams fork, without boundary edges
  kBoundary,        ///< position on a boundary: two boundary edges and no seam edge end there
  kBoundaryCorner,  ///< position with any other combination of feature edges
};

constexpr uint32_t kManyWedges = ~0u;

/// State of a position during simplification, except its point and quadric.
struct CollapsePosition {
  uint32_t first = 0, count = 0, capacity = 0;  ///< range of the position's corner list in CollapseMesh::pool
  uint32_t merged_at = 0;                       ///< number of the last collapse into this position; 0: none
  PositionKind kind = PositionKind::kSmooth;
  bool locked = false;  ///< true if the position may not move, because other nodes share it
  uint8_t lca_depth = kNeverLocked;
};

/// A node's mesh during simplification. Stores the position and the wedge of each triangle's corners, and
/// lists the corners at each position. Triangle t has the corners 4t, 4t + 1 and 4t + 2. The lists do not
/// contain corners of removed triangles.
struct CollapseMesh {
  /// @param node_depth  see CollapseOptions
  CollapseMesh(NodeMesh&& mesh, int node_depth);

  bool hasWedges() const noexcept { return !corner_wedge.empty(); }
  // next() and previous() are branchless, because the processor would mispredict half of the branches.
  static uint32_t next(uint32_t corner) noexcept { return corner + 1 - 3 * (corner >> 1 & 1); }
  static uint32_t previous(uint32_t corner) noexcept { return corner + 2 - 3 * ((corner | corner >> 1) & 1); }
  /// Returns the corners at a position, one per triangle.
  std::span<const uint32_t> around(uint32_t position) const noexcept {
    return {pool.data() + positions[position].first, positions[position].count};
  }

  /// Prefetches the triangles around a position.
  void prefetchCorners(uint32_t position) const noexcept {
    __builtin_prefetch(pool.data() + positions[position].first);
  }

  uint32_t at(uint32_t corner) const noexcept { return corner_position[corner]; }
  glm::dvec3 point(uint32_t position) const noexcept { return glm::dvec3(points[position]); }

  /// An edge, with the wedges at its ends in the first of its triangles that was found.
  struct Edge {
    uint32_t u, v;
    uint32_t uses;
    uint32_t corner;  ///< corner at u of one of the edge's triangles
    uint32_t wedge_u, wedge_v;
    bool seam;

    EdgeKind kind() const noexcept {
      return uses != 2 ? EdgeKind::kBoundary : seam ? EdgeKind::kSeam : EdgeKind::kSmooth;
    }
  };
  /// Returns the kind of an edge; kSmooth if no triangle has the edge.
  EdgeKind edgeKind(uint32_t u, uint32_t v) const noexcept;
  /// Calls visit(edge) once for every edge, with u < v, in order of u. Does not build a list of all edges,
  /// because such a list would take a sixth of a large node's memory.
  template <typename Visit>
  void forEachEdge(Visit&& visit) const {
    std::vector<uint32_t> places(positions.size());
    std::vector<Edge> edges;
    for (uint32_t u = 0; u < positions.size(); ++u) {
      findEdges(u, edges, places);
      for (const Edge& edge : edges) visit(edge);
    }
  }
  /// Sets the kind of every position. @param visit  called for every edge, as by forEachEdge()
  template <typename Visit>
  void classifyPositions(Visit&& visit) {
    std::vector<Features> features(positions.size());
    forEachEdge([&](const Edge& edge) {
      count(edge, features);
      visit(edge);
    });
    classify(features);
  }

  /// Moves `keep` to `point`, merges `gone` into `keep` and removes the triangles that have both as corners.
  /// @param gone_share  position of `point` between `keep` (0) and `gone` (1); also the weight of the
  /// attributes of `gone`
  void merge(uint32_t keep, uint32_t gone, glm::dvec3 point, double gone_share);
  /// Returns the pairs of wedges that the last merge() joined.
  std::span<const WedgeTable::Pair> joined() const noexcept { return pairs_; }
  /// Fills `pairs` with the wedges that a merge would join: each a wedge of `gone` and a wedge of `keep`.
  void findPairs(uint32_t keep, uint32_t gone, std::vector<WedgeTable::Pair>& pairs);
  /// Calls visit(wedge) once for each wedge at a position.
  template <typename Visit>
  void forEachWedge(uint32_t position, Visit&& visit) {
    if (only_wedge[position] != kManyWedges) return visit(only_wedge[position]);
    const uint64_t stamp = newStamp();
    for (const uint32_t corner : around(position)) {
      const uint32_t wedge = corner_wedge[corner];
      if (std::exchange(wedge_marks_[wedge], stamp) != stamp) visit(wedge);
    }
  }
  /// Removes identical triangles of opposite orientation around a position, in pairs.
  void removeFolds(uint32_t position);

  /// Returns the remaining mesh, compacted, in the order of the input.
  /// @param new_position  receives for each position its index in the result, or kVanished.
  NodeMesh compact(std::vector<uint32_t>& new_position) const;

  AttributeSet attributes;
  glm::dvec3 origin{0};  ///< origin of `points`, in whole lattice steps
  /// Points of the positions, in whole lattice steps from `origin`; the fourth component is unused. Separate
  /// from the other data of positions, because a check of a triangle reads only three points.
  std::vector<glm::ivec4> points;
  std::vector<CollapsePosition> positions;
  std::vector<Quadric> quadrics;  ///< quadric of each position
  std::vector<float> areas;       ///< total area of the triangles in each position's quadric
  /// Position of each corner. A triangle has four entries; the last of them is unused.
  std::vector<uint32_t> corner_position;
  std::vector<uint32_t> corner_wedge;  ///< wedge of each corner, in the same layout; empty without attributes
  /// The only wedge of each position, or kManyWedges if it has several; empty without attributes.
  std::vector<uint32_t> only_wedge;
  std::vector<uint32_t> pool;  ///< corner lists of the positions
  WedgeTable wedges;
  bool mixes_values = true;  ///< true if merge() mixes the attributes of joined wedges
  size_t live_triangles = 0;

 private:
  /// Numbers of seam edges and of boundary edges that end at a position. Each number stops at 3, which means
  /// three or more.
  struct Features {
    uint8_t seams = 0, boundaries = 0;
  };

  void gatherCorners();
  /// Returns a mark that no wedge has.
  uint64_t newStamp() {
    if (wedge_marks_.empty()) wedge_marks_.resize(wedges.size());
    return ++wedge_stamp_;
  }
  /// Fills `edges` with the edges from u to positions with larger indices. @param places  for each position,
  /// its index in `edges`; entries from earlier calls are ignored
  void findEdges(uint32_t u, std::vector<Edge>& edges, std::vector<uint32_t>& places) const;
  static void count(const Edge& edge, std::vector<Features>& features) {
    const EdgeKind kind = edge.kind();
    if (kind == EdgeKind::kSmooth) return;
    for (const uint32_t end : {edge.u, edge.v}) {
      uint8_t& n = kind == EdgeKind::kSeam ? features[end].seams : features[end].boundaries;
      n = static_cast<uint8_t>(std::min(n + 1, 3));
    }
  }
  void classify(const std::vector<Features>& features);
  /// Removes a corner from its position's list.
  void unlist(uint32_t corner);
  /// Records the slots of a list's corners from index `from` on, if the list is longer than kLongList.
  void noteSlots(const CollapsePosition& list, uint32_t from);
  /// Removes the triangle of a corner. @param is_listed  true if the list of the corner's position contains
  /// the corner
  void kill(uint32_t corner, bool is_listed);
  /// Removes the triangles of all given corners, like kill(). The time is proportional to the number of
  /// corners and to the lengths of the lists that contain them.
  void killAll(std::span<const uint32_t> corners, bool are_listed);
  uint32_t findOnlyWedge(uint32_t position) const noexcept;
  bool share(uint32_t keep, uint32_t gone) const noexcept;
  void mergeWedges(uint32_t keep, uint32_t gone, double gone_share);

  // For each corner in a long list, its index in `pool`; empty if no list is long.
  std::vector<uint32_t> slots_;
  std::vector<uint64_t> wedge_marks_;  // last stamp of each wedge
  uint64_t wedge_stamp_ = 0;
  std::vector<uint32_t> dying_;          // corners to remove; buffer that is reused between calls
  std::vector<WedgeTable::Pair> pairs_;  // pairs joined by the last merge()
};

/// Adds two terms to the quadric of each position: the planes of the position's triangles, weighted by area,
/// and the position's own point, with a small weight.
void addPlanes(CollapseMesh& mesh);
/// Adds to both ends of a boundary or seam edge a plane perpendicular to the surface, which keeps the edge in
/// place. Does nothing for other edges.
void addFeature(CollapseMesh& mesh, const CollapseMesh::Edge& edge);

}  // namespace lode::ingest
