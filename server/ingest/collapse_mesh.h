#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/node_mesh.h"
#include "server/ingest/wedge_values.h"

namespace lode::ingest {

/// What meets along an edge.
enum class EdgeKind : uint8_t {
  kSmooth,  ///< two triangles that share both wedges
  kSeam,    ///< two triangles with different wedges at an end
  kRim,     ///< one triangle, or more than two
};

/// What meets at a position, by the feature edges (seams and rims) that end there.
enum class PositionKind : uint8_t {
  kSmooth,      ///< none
  kSeam,        ///< inside a seam: two, no rim
  kSeamCorner,  ///< an end or a fork of seams
  kRim,         ///< inside a rim: two rims, no seam
  kRimCorner,   ///< anything else
};

/// A node's mesh while it is simplified: triangles by position and by wedge, and the triangles around each
/// position. A corner's number is 4 * triangle + 0..2; a dead triangle is in no ring.
struct CollapseMesh {
  struct Ring {
    uint32_t first = 0, count = 0, capacity = 0;
  };

  /// @param node_depth  see CollapseOptions
  CollapseMesh(NodeMesh&& mesh, int node_depth);

  bool hasWedges() const noexcept { return !corner_wedge.empty(); }
  static uint32_t next(uint32_t corner) noexcept { return (corner & 3) == 2 ? corner - 2 : corner + 1; }
  static uint32_t previous(uint32_t corner) noexcept { return (corner & 3) == 0 ? corner + 2 : corner - 1; }
  /// Corners that lie at a position, one a triangle.
  std::span<const uint32_t> around(uint32_t position) const noexcept {
    return {pool.data() + rings[position].first, rings[position].count};
  }

  /// One edge and the wedges of the first triangle found there.
  struct Edge {
    uint32_t u, v;
    uint32_t uses;
    uint32_t corner;  ///< of u, in one of the edge's triangles
    uint32_t wedge_u, wedge_v;
    bool seam;

    EdgeKind kind() const noexcept {
      return uses != 2 ? EdgeKind::kRim : seam ? EdgeKind::kSeam : EdgeKind::kSmooth;
    }
  };
  /// Calls visit(const Edge&) for every edge once, u < v, by rising u.
  template <typename Visit>
  void forEachEdge(Visit&& visit) const;
  /// kSmooth too where no triangle has the edge.
  EdgeKind edgeKind(uint32_t u, uint32_t v) const noexcept;
  /// Sets position_kind from all edges.
  void classifyPositions();

  /// Moves `keep` to `point` and gives it all that is at `gone`; triangles with both die.
  /// @param gone_share  how far the point lies from keep (0) to gone (1): attributes are mixed so
  void merge(uint32_t keep, uint32_t gone, glm::dvec3 point, double gone_share);
  /// Removes identical triangles of opposite orientation around a position, in pairs.
  void removeFolds(uint32_t position);

  /// The live mesh with only what it uses, in the order of the input.
  NodeMesh compact() const;

  AttributeSet attributes;
  glm::dvec3 origin{0};            ///< added to points gives lattice coordinates; whole numbers
  std::vector<glm::dvec3> points;  ///< whole numbers of lattice steps
  std::vector<uint8_t> lca_depth;
  std::vector<uint8_t> locked;
  std::vector<PositionKind> position_kind;
  std::vector<uint32_t> corner_position;  ///< four a triangle, the last unused
  std::vector<uint32_t> corner_wedge;     ///< the same, or empty where there are no attributes
  std::vector<Ring> rings;
  std::vector<uint32_t> pool;  ///< of the rings
  WedgeTable wedges;
  size_t live_triangles = 0;

 private:
  void buildRings();
  void kill(uint32_t triangle, uint32_t except);
  void mergeWedges(uint32_t keep, uint32_t gone, double gone_share);

  std::vector<uint32_t> dying_;          // corners of `gone`, scratch
  std::vector<WedgeTable::Pair> pairs_;  // scratch
};

template <typename Visit>
void CollapseMesh::forEachEdge(Visit&& visit) const {
  std::vector<uint32_t> slot(points.size(), 0);
  std::vector<Edge> local;
  const uint32_t positions = static_cast<uint32_t>(points.size());
  for (uint32_t u = 0; u < positions; ++u) {
    local.clear();
    for (const uint32_t corner : around(u)) {
      for (const uint32_t other : {next(corner), previous(corner)}) {
        const uint32_t v = corner_position[other];
        if (v < u) continue;
        const uint32_t wedge_u = hasWedges() ? corner_wedge[corner] : 0;
        const uint32_t wedge_v = hasWedges() ? corner_wedge[other] : 0;
        if (slot[v] < local.size() && local[slot[v]].v == v) {
          Edge& edge = local[slot[v]];
          ++edge.uses;
          edge.seam |= edge.wedge_u != wedge_u || edge.wedge_v != wedge_v;
        } else {
          slot[v] = static_cast<uint32_t>(local.size());
          local.push_back({u, v, 1, corner, wedge_u, wedge_v, false});
        }
      }
    }
    for (const Edge& edge : local) visit(edge);
  }
}

}  // namespace lode::ingest
