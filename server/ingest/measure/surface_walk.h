#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/measure/triangle_tree.h"
#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/mesh/segment_distance.h"

namespace lode::ingest {

/// Triangles of a surface, each of which shares an edge with the next.
struct TriangleChain {
  static constexpr size_t kMostEdges = 6;

  FourSegments eachTwice(size_t edge, size_t other) const noexcept {
    return {FourVectors(from[edge], from[edge], from[other], from[other]),
            FourVectors(to[edge], to[edge], to[other], to[other])};
  }

  std::array<uint32_t, kMostEdges + 1> triangles;
  std::array<Four, kMostEdges> from, to;  ///< ends of the shared edges
  size_t edge_count = 0;
};

/// Finds the distance from a point to a mesh, in lattice steps, by a walk. The walk goes from the triangles
/// around one position to those around a neighbouring position, as long as the distance decreases. The result
/// is never smaller than the true distance. The result is larger than the true distance if every path to the
/// nearest triangle first leads away from the point, if the nearest triangle is on another piece of the mesh,
/// or if very many triangles meet at a position. If a position near the point is known, a walk is much faster
/// than a TriangleTree. Const functions are thread safe.
class SurfaceWalk {
 public:
  /// @param mesh  the mesh to walk on.
  explicit SurfaceWalk(const NodeMesh& mesh);

  /// Walks from `start` and returns the smallest distance found. @param point  the point to measure from, in
  /// lattice steps like all points in this class.
  /// @param start  a position of the mesh; the result is infinite if no triangle has this position.
  /// @param tolerance  the walk ends as soon as the distance is at most `tolerance`.
  float distance(glm::vec3 point, uint32_t start, float tolerance) const noexcept;
  /// Like distance(), but sets `start` to the position at which the walk ends, a better start for points
  /// nearby.
  float distanceAndAdvance(glm::vec3 point, uint32_t& start, float tolerance) const noexcept;
  /// Returns the squared distance of a point from one triangle.
  float squaredDistance(glm::vec3 point, uint32_t triangle) const noexcept {
    return triangles_[triangle].squaredDistance(point);
  }
  const PackedTriangle& triangle(uint32_t number) const noexcept { return triangles_[number]; }
  /// Like distance(), but starts at `triangle`, and sets `triangle` to the triangle at which the walk ends.
  float distanceFrom(glm::vec3 point, uint32_t& triangle, float tolerance) const noexcept;
  /// A point on the mesh, usually the one nearest to a point that was measured.
  struct Place {
    uint32_t triangle = 0;  ///< number of the triangle in the mesh
    glm::vec3 shares{0};    ///< barycentric weights of the triangle's corners
    float distance = 0;     ///< distance from the measured point
  };
  /// Returns the projection of `point` into a triangle around `start`. If the point projects into no such
  /// triangle, returns the place at which a walk from `start` ends.
  /// @param start  a position that is a corner of some triangle.
  Place placeOf(glm::vec3 point, uint32_t start) const noexcept;
  /// Returns the place of a position that is a corner of some triangle.
  Place placeAt(uint32_t position) const noexcept;
  /// Finds a chain of triangles below a segment, from the triangle `first` below the segment's start to the
  /// triangle `last` below its end. The chain may also end at another triangle that the segment's end
  /// projects into, if their squared distance is at most `near_squared`.
  /// @return false if the function finds no such chain.
  bool chainAlong(const Segment& segment, uint32_t first, uint32_t last, float near_squared,
                  TriangleChain& chain) const noexcept;
  /// Searches all triangles for the nearest one. @param bound  the result if no triangle is nearer.
  TriangleTree::Nearest nearestOfAll(glm::vec3 point, TriangleTree::Nearest bound) const noexcept;

 private:
  struct Nearest {
    float squared;
    uint32_t triangle;
  };
  Nearest walk(glm::vec3 point, uint32_t start, float tolerance_squared) const noexcept;
  std::optional<Place> placeAround(glm::vec3 point, uint32_t position) const noexcept;
  void visit(glm::vec3 point, uint32_t triangle, Nearest& best) const noexcept;
  /// Returns the four triangles from index `begin` in around_; repeats the last triangle if fewer remain
  /// before `end`.
  FourTriangles trianglesFrom(uint32_t begin, uint32_t end) const noexcept {
    const auto at = [&](uint32_t i) -> const PackedTriangle& {
      return triangles_[around_[std::min(begin + i, end - 1)]];
    };
    return {at(0), at(1), at(2), at(3)};
  }
  /// Returns the other triangle at the edge of `triangle` between two positions, or `triangle` itself if the
  /// edge has no other.
  uint32_t acrossEdge(uint32_t triangle, uint32_t from, uint32_t to) const noexcept;
  /// Sorts the triangles around a position by their angle around an axis. The axis is the mean of the
  /// directions to the triangles. If the triangles lie on all sides, the axis is the coordinate axis along
  /// which they extend least.
  void sortAround(uint32_t position, glm::vec3 at);
  /// Returns true if so many triangles meet at a position that a walk visits only some of them.
  bool isHub(uint32_t position) const noexcept;
  bool isAbove(glm::vec3 point, uint32_t triangle) const noexcept;
  void visitAbove(glm::vec3 point, uint32_t position, float tolerance_squared, Nearest& best) const noexcept;
  void visitAround(glm::vec3 point, uint32_t position, float tolerance_squared, Nearest& best) const noexcept;
  void visitSome(const FourVectors& points, uint32_t begin, uint32_t end, float tolerance_squared,
                 Nearest& best) const noexcept;
  /// Visits the four triangles of trianglesFrom(begin, end). @return the smallest squared distance from the
  /// point to one of them.
  float visitFour(const FourVectors& points, uint32_t begin, uint32_t end, float tolerance_squared,
                  Nearest& best) const noexcept;

  float longest_edge_ = 0;
  std::vector<PackedTriangle> triangles_;
  std::vector<glm::u32vec3> corners_;  ///< positions of each triangle's corners
  /// Triangles around each position: around_[begin_[position]] up to around_[begin_[position + 1]].
  std::vector<uint32_t> begin_, around_;
};

}  // namespace lode::ingest
