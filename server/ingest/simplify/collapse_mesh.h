#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/simplify/quadric.h"
#include "server/ingest/simplify/wedge_values.h"

namespace lode::ingest {

/// What meets along an edge.
enum class EdgeKind : uint8_t {
  kSmooth,    ///< two triangles that share both wedges
  kSeam,      ///< two triangles with different wedges at an end
  kBoundary,  ///< one triangle, or more than two
};

/// What meets at a position, by the feature edges (seams and boundaries) that end there.
enum class PositionKind : uint8_t {
  kSmooth,          ///< none
  kSeam,            ///< inside a seam: two, no boundary
  kSeamCorner,      ///< an end or a fork of seams
  kBoundary,        ///< inside a boundary: two boundaries, no seam
  kBoundaryCorner,  ///< anything else
};

constexpr uint32_t kManyWedges = ~0u;

/// What is known of a position while its mesh is simplified, but its place and its quadric.
struct CollapsePosition {
  uint32_t first = 0, count = 0, capacity = 0;  ///< its corners' place in the mesh's pool
  uint32_t merged_at = 0;                       ///< when another was last merged into it
  PositionKind kind = PositionKind::kSmooth;
  bool locked = false;
  uint8_t lca_depth = kNeverLocked;
};

/// A node's mesh while it is simplified: triangles by position and by wedge, and the triangles around each
/// position. A corner's number is 4 * triangle + 0..2; a dead triangle is in no position's list.
struct CollapseMesh {
  /// @param node_depth  see CollapseOptions
  CollapseMesh(NodeMesh&& mesh, int node_depth);

  bool hasWedges() const noexcept { return !corner_wedge.empty(); }
  // Branches here would go either way as often.
  static uint32_t next(uint32_t corner) noexcept { return corner + 1 - 3 * (corner >> 1 & 1); }
  static uint32_t previous(uint32_t corner) noexcept { return corner + 2 - 3 * ((corner | corner >> 1) & 1); }
  /// Corners that lie at a position, one a triangle.
  std::span<const uint32_t> around(uint32_t position) const noexcept {
    return {pool.data() + positions[position].first, positions[position].count};
  }

  /// Gets ready to go through the triangles around a position.
  void fetchCorners(uint32_t position) const noexcept {
    __builtin_prefetch(pool.data() + positions[position].first);
  }

  uint32_t at(uint32_t corner) const noexcept { return corner_position[corner]; }
  glm::dvec3 point(uint32_t position) const noexcept { return glm::dvec3(points[position]); }

  /// One edge and the wedges of the first triangle found there.
  struct Edge {
    uint32_t u, v;
    uint32_t uses;
    uint32_t corner;  ///< of u, in one of the edge's triangles
    uint32_t wedge_u, wedge_v;
    bool seam;

    EdgeKind kind() const noexcept {
      return uses != 2 ? EdgeKind::kBoundary : seam ? EdgeKind::kSeam : EdgeKind::kSmooth;
    }
  };
  /// kSmooth too where no triangle has the edge.
  EdgeKind edgeKind(uint32_t u, uint32_t v) const noexcept;
  /// Calls visit(edge) for every edge once, u < v, by rising u. No list of all is made: of a large node it
  /// would be a sixth of all that is held.
  template <typename Visit>
  void forEachEdge(Visit&& visit) const {
    std::vector<uint32_t> places(positions.size());
    std::vector<Edge> edges;
    for (uint32_t u = 0; u < positions.size(); ++u) {
      findEdges(u, edges, places);
      for (const Edge& edge : edges) visit(edge);
    }
  }
  /// Sets every position's kind from all edges. @param visit  called as by forEachEdge()
  template <typename Visit>
  void classifyPositions(Visit&& visit) {
    std::vector<Features> features(positions.size());
    forEachEdge([&](const Edge& edge) {
      count(edge, features);
      visit(edge);
    });
    classify(features);
  }

  /// Moves `keep` to `point` and gives it all that is at `gone`; triangles with both die.
  /// @param gone_share  how far the point lies from keep (0) to gone (1): attributes are mixed so
  void merge(uint32_t keep, uint32_t gone, glm::dvec3 point, double gone_share);
  /// The wedges that the last merge() has joined.
  std::span<const WedgeTable::Pair> joined() const noexcept { return pairs_; }
  /// Fills `pairs` with the wedges of `gone` and those of `keep` that a merge would join them to.
  void findPairs(uint32_t keep, uint32_t gone, std::vector<WedgeTable::Pair>& pairs) const;
  /// Calls visit(wedge) for each wedge at a position once.
  template <typename Visit>
  void forEachWedge(uint32_t position, Visit&& visit) const {
    if (only_wedge[position] != kManyWedges) return visit(only_wedge[position]);
    const std::span<const uint32_t> corners = around(position);
    for (size_t i = 0; i < corners.size(); ++i) {
      bool seen = false;
      for (size_t j = 0; j < i && !seen; ++j) seen = corner_wedge[corners[j]] == corner_wedge[corners[i]];
      if (!seen) visit(corner_wedge[corners[i]]);
    }
  }
  /// Removes identical triangles of opposite orientation around a position, in pairs.
  void removeFolds(uint32_t position);

  /// The live mesh with only what it uses, in the order of the input.
  /// @param new_position  gets the number of each position in it, or kVanished.
  NodeMesh compact(std::vector<uint32_t>& new_position) const;

  AttributeSet attributes;
  glm::dvec3 origin{0};  ///< whole lattice steps; points are relative to it
  /// Whole lattice steps, apart from all else: a look at a triangle takes three of them. The fourth is
  /// unused.
  std::vector<glm::ivec4> points;
  std::vector<CollapsePosition> positions;
  std::vector<Quadric> quadrics;          ///< a position's
  std::vector<float> areas;               ///< of the triangles that its quadric is made of
  std::vector<uint32_t> corner_position;  ///< four a triangle, the last unused
  std::vector<uint32_t> corner_wedge;     ///< the same, or empty where there are no attributes
  std::vector<uint32_t> only_wedge;  ///< a position's, or kManyWedges; empty where there are no attributes
  std::vector<uint32_t> pool;        ///< corners by position, in pieces
  WedgeTable wedges;
  bool mixes_values = true;  ///< merge() mixes the attributes of wedges that it joins
  size_t live_triangles = 0;

 private:
  /// How many feature edges end at a position, up to 3.
  struct Features {
    uint8_t seams = 0, boundaries = 0;
  };

  void gatherCorners();
  /// Puts the edges from u to higher positions into `edges`. @param places  a position's place there, if it
  /// has one; anything else else.
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
  /// Takes a corner out of its position's list.
  void unlist(uint32_t corner);
  /// Removes the triangle of a corner. @param is_listed  the corner's own position has a list that it stands
  /// in
  void kill(uint32_t corner, bool is_listed);
  /// kill() of each, in time proportional to them and the lists that they stand in.
  void killAll(std::span<const uint32_t> corners, bool are_listed);
  uint32_t findOnlyWedge(uint32_t position) const noexcept;
  bool share(uint32_t keep, uint32_t gone) const noexcept;
  void mergeWedges(uint32_t keep, uint32_t gone, double gone_share);

  std::vector<uint32_t> dying_;          // corners, scratch
  std::vector<WedgeTable::Pair> pairs_;  // scratch
};

/// Gives each position the quadric of what meets there: the planes of its triangles by their area, and a
/// little of its own place.
void addPlanes(CollapseMesh& mesh);
/// Adds to the ends of a boundary or a seam a plane upright on it, so that it keeps its course; to those of
/// another edge nothing.
void addFeature(CollapseMesh& mesh, const CollapseMesh::Edge& edge);

}  // namespace lode::ingest
