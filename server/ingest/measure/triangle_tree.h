#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/mesh/four_triangles.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// Limits the total work of many searches, for meshes in which the boxes of nearly all triangles overlap.
/// Searches of other meshes stay far below the limit. Not thread safe.
class SearchEffort {
 public:
  /// Begins a search. @return number of leaves that the search may visit; the search decrements this number
  /// at each leaf.
  uint64_t& begin() noexcept { return left_ += kLeavesPerSearch; }

 private:
  static constexpr uint64_t kLeavesPerSearch = 192, kLeavesAtFirst = 1u << 16;
  uint64_t left_ = kLeavesAtFirst;
};

/// Finds the distance from a point to a mesh, in lattice steps, by a tree of boxes around the mesh's
/// triangles. Each step of the construction halves a set of triangles at the median along the longest side of
/// the box around their centroids. A search tests four boxes or four triangles at once. Unlike a grid, the
/// tree costs nothing for empty space around a point. Const functions are thread safe.
/// Source: Wald, Benthin & Boulos, Getting Rid of Packets, 2008, for trees of four.
class TriangleTree {
 public:
  explicit TriangleTree(const NodeMesh& mesh);

  static constexpr float kInfinity = std::numeric_limits<float>::infinity();
  struct Nearest {
    float squared;   ///< squared distance
    float distance;  ///< distance of the triangle; infinite if the mesh has no triangles
    uint32_t triangle;
  };
  static constexpr Nearest kNothing{kInfinity, kInfinity, 0};

  /// Returns the triangle nearest to `point`. @param tolerance  the search ends at any triangle within this
  /// distance.
  /// @param bound      the result if no triangle is nearer; a smaller bound makes the search shorter.
  Nearest nearest(glm::vec3 point, float tolerance = 0, Nearest bound = kNothing) const noexcept {
    uint64_t leaves = ~uint64_t{0};
    return nearestWithin(point, tolerance, bound, leaves);
  }
  /// Like nearest(), but the result may be farther than the nearest triangle if the effort is used up.
  Nearest nearest(glm::vec3 point, float tolerance, Nearest bound, SearchEffort& effort) const noexcept {
    return nearestWithin(point, tolerance, bound, effort.begin());
  }
  float distance(glm::vec3 point) const noexcept { return nearest(point).distance; }
  struct ExactNearest {
    double distance;
    uint32_t triangle;
  };
  /// Like nearest(), but measures triangles in double precision: see nearestPointOfTriangle(). Single
  /// precision overestimates distances from triangles that are thousands of times as long as wide.
  ExactNearest nearestExactly(glm::dvec3 point, double tolerance, ExactNearest bound) const noexcept;
  /// Returns the squared distance of a point from one triangle.
  float squaredDistance(glm::vec3 point, uint32_t triangle) const noexcept {
    return triangles_[place_[triangle]].squaredDistance(point);
  }
  const PackedTriangle& triangle(uint32_t number) const noexcept { return triangles_[place_[number]]; }

 private:
  /// An inner node of the tree: the boxes of up to four forks or leaves. Unused boxes are infinitely far
  /// away.
  struct Fork {
    FourVectors min, max;
    /// Content of each box: an index in forks_ or, with the bit kIsLeaf, the index in triangles_ of a leaf's
    /// first triangle.
    std::array<uint32_t, 4> inside{};

    Four squaredDistances(const FourVectors& points) const noexcept;
  };
  struct Box {
    glm::vec3 min{kInfinity}, max{-kInfinity};
  };
  struct Middle {
    glm::vec3 at;
    uint32_t triangle;
  };
  /// A box and its content.
  struct Branch {
    uint32_t inside = 0;
    Box box;
  };
  template <typename Reach, typename Visit>
  void search(const FourVectors& points, const Reach& reach, const Visit& visit) const noexcept;
  /// @param leaves  number of leaves that the search may visit; each visit decrements it.
  Nearest nearestWithin(glm::vec3 point, float tolerance, Nearest bound, uint64_t& leaves) const noexcept;
  Branch build(const NodeMesh& mesh, std::span<Middle> middles);
  static size_t partInHalves(std::span<Middle> middles);
  Branch buildLeaf(const NodeMesh& mesh, std::span<const Middle> middles);

  static constexpr uint32_t kIsLeaf = 1u << 31;

  std::vector<Fork> forks_;
  /// Four triangles per leaf; empty triangles fill a leaf with fewer triangles.
  std::vector<PackedTriangle> triangles_;
  std::vector<uint32_t> number_;  ///< for each entry of triangles_, the triangle's number in the mesh
  std::vector<uint32_t> place_;   ///< for each triangle of the mesh, its index in triangles_
  uint32_t top_ = 0;
};

}  // namespace lode::ingest
