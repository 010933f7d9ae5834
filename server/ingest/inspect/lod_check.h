#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "common/mesh.h"
#include "server/ingest/measure/surface_walk.h"
#include "server/ingest/measure/triangle_tree.h"
#include "server/ingest/mesh/number_table.h"
#include "server/store/open_edges.h"

namespace lode::ingest {

/// Pseudo-random numbers in [0, 1), equal on all platforms.
class Dice {
 public:
  explicit Dice(uint64_t seed) : state_(NumberTable::hash(seed + 1)) {}
  double roll() noexcept {
    state_ += 0x9e3779b97f4a7c15ULL;
    return static_cast<double>(NumberTable::hash(state_) >> 11) * 0x1p-53;
  }

 private:
  uint64_t state_;
};

/// A point of an LOD or of the leaves below its node, and its distance from the other of these two surfaces.
struct FarPoint {
  double steps = 0;          ///< distance in lattice steps
  glm::dvec3 at{0};          ///< the point in lattice coordinates
  bool of_lod = false;       ///< true if the point is on the LOD, false if it is on a leaf
  bool on_boundary = false;  ///< true if `steps` is the distance from a boundary of the leaves

  /// Replaces this point by `other` if that is farther, or equally far and first in coordinate order, so that
  /// the result does not depend on the order of calls.
  void raiseTo(const FarPoint& other) noexcept;
};

/// A leaf of a store with a search tree. Const functions are thread safe.
struct LeafSurface {
  explicit LeafSurface(const Mesh& leaf);

  LatticeBox box;
  std::vector<glm::uvec3> positions;
  std::vector<glm::u32vec3> triangles;
  TriangleTree tree;  ///< tree of the triangles, in lattice steps from the box's minimum
};

/// Measures the largest distance between an LOD and the leaves below its node, in both directions: from every
/// triangle of the leaves to the LOD (see FarthestInTriangle), and from points of the LOD to the leaves. Any
/// thread may add leaves, in any order.
class LodCheck {
 public:
  /// @param box  box of the LOD's node. @param stored_steps  the stored error, in lattice steps.
  /// @param original  number of triangles below the node. @param seed  selects points inside triangles.
  LodCheck(const Mesh& lod, const LatticeBox& box, float stored_steps, uint64_t original, uint64_t seed);

  /// Compares the LOD with a leaf. Thread safe.
  void add(const LeafSurface& leaf);
  /// Returns the farthest point; call after adding the last leaf. The returned distance is at least 3/4 of
  /// the stored error, even if no point is that far away. Larger distances are exact. Exception: if a point
  /// of the LOD is farther away than 1.25 times the stored error, the result is between 1.25 and 1.3 times
  /// the stored error.
  FarPoint farthest() const;
  double found() const { return farthest().steps; }

 private:
  LodCheck(const NodeMesh& lod, const LatticeBox& box, float stored_steps);
  void placePoints(const Mesh& lod, uint64_t count, Dice dice);
  void sortPoints();
  FarPoint farthestOf(const LeafSurface& leaf) const;
  void bringNearer(const LeafSurface& leaf);
  float distanceTo(const LeafSurface& leaf, glm::dvec3 point, float bound, uint32_t& last) const;
  glm::ivec3 cellOf(glm::dvec3 point) const;

  const glm::uvec3 origin_;
  const float stored_;
  const TriangleTree tree_;
  const SurfaceWalk walk_;          ///< walk over the LOD, which makes most searches in tree_ unnecessary
  std::vector<glm::dvec3> points_;  ///< points on the LOD's surface, sorted by cell
  std::vector<std::atomic<float>> nearest_;
  /// Index of each cell's first point; the last element is the number of points.
  std::vector<uint32_t> begin_;
  int cells_ = 1;  ///< number of cells along each axis
  glm::dvec3 cell_size_{1};
  std::mutex mutex_;
  FarPoint forward_;  ///< farthest point of the leaves from the LOD
};

/// Measures the largest distance from the boundaries of each LOD of a node to the boundaries of the leaves
/// below the node. Edges on the border to neighbouring nodes also count as boundaries; they are the same in
/// the LODs and in the leaves. Any thread may add leaves, in any order.
class BoundaryCheck {
 public:
  /// Adds an LOD. Call addLod() before addLeaf(). LODs are numbered in the order of the calls.
  void addLod(const Mesh& lod);
  /// Adds the boundaries of a leaf. @param boundaries  open edges of the leaf. Thread safe.
  void addLeaf(std::span<const store::OpenEdge> boundaries);
  /// Returns for each LOD the point of its boundaries that is farthest from the leaves' boundaries. Call
  /// after adding the last leaf.
  std::vector<FarPoint> farthest();

 private:
  std::mutex mutex_;
  store::OpenEdges of_leaves_;
  std::vector<std::vector<store::OpenEdge>> of_lods_;
};

}  // namespace lode::ingest
