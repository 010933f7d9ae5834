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

/// Distance from points to a mesh, in lattice steps, by a tree of boxes around its triangles, halved by
/// number along the longest side of their middles; four boxes or four triangles are looked at at once. Empty
/// space around a point costs nothing, unlike in a grid's cells. Const functions are thread safe.
/// Source: Wald, Benthin & Boulos, Getting Rid of Packets, 2008, for trees of four.
class TriangleTree {
 public:
  explicit TriangleTree(const NodeMesh& mesh);

  static constexpr float kInfinity = std::numeric_limits<float>::infinity();
  struct Nearest {
    float squared;   ///< of the distance
    float distance;  ///< infinity if the mesh has no triangles
    uint32_t triangle;
  };
  static constexpr Nearest kNothing{kInfinity, kInfinity, 0};

  /// @param enough  the search ends at a triangle that is as near as this, which need not be the nearest.
  /// @param known   what is returned if no triangle is nearer: the nearer it is, the shorter is the search.
  Nearest nearest(glm::vec3 point, float enough = 0, Nearest known = kNothing) const noexcept;
  float distance(glm::vec3 point) const noexcept { return nearest(point).distance; }
  /// From one of the mesh's triangles.
  float squaredDistance(glm::vec3 point, uint32_t triangle) const noexcept {
    return triangles_[place_[triangle]].squaredDistance(point);
  }
  const PackedTriangle& triangle(uint32_t number) const noexcept { return triangles_[place_[number]]; }

 private:
  /// Boxes around up to four forks or leaves; those that there are not are infinitely far.
  struct Fork {
    FourVectors min, max;
    std::array<uint32_t, 4> inside{};  ///< of forks_, or of triangles_, where a leaf's begin, with kIsLeaf

    Four squaredDistances(const FourVectors& points) const noexcept;
  };
  struct Box {
    glm::vec3 min{kInfinity}, max{-kInfinity};
  };
  struct Middle {
    glm::vec3 at;
    uint32_t triangle;
  };
  /// A box and what is in it.
  struct Branch {
    uint32_t inside = 0;
    Box box;
  };
  Branch build(const NodeMesh& mesh, std::span<Middle> middles);
  static size_t partInHalves(std::span<Middle> middles);
  Branch buildLeaf(const NodeMesh& mesh, std::span<const Middle> middles);

  static constexpr uint32_t kIsLeaf = 1u << 31;

  std::vector<Fork> forks_;
  std::vector<PackedTriangle> triangles_;  ///< four a leaf, the last ones of which may be none
  std::vector<uint32_t> number_;           ///< of each of those in the mesh
  std::vector<uint32_t> place_;            ///< of each of the mesh's in triangles_
  uint32_t top_ = 0;
};

}  // namespace lode::ingest
