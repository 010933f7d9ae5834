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

/// Pseudo-random numbers from 0 to 1, the same everywhere.
class Dice {
 public:
  explicit Dice(uint64_t seed) : state_(NumberTable::hash(seed + 1)) {}
  float roll() noexcept {
    state_ += 0x9e3779b97f4a7c15ULL;
    return static_cast<float>(NumberTable::hash(state_) >> 40) * 0x1p-24f;
  }

 private:
  uint64_t state_;
};

/// A leaf of a store, ready to be measured against. Const functions are thread safe.
struct LeafSurface {
  explicit LeafSurface(const Mesh& leaf);

  LatticeBox box;
  std::vector<glm::uvec3> positions;
  std::vector<glm::u32vec3> triangles;
  TriangleTree tree;  ///< in steps from the box's least corner
};

/// Looks for the largest distance between an LOD and the leaves below its node, which come one by one in any
/// order, on any threads: of the leaves every triangle (see FarthestInTriangle), of the LOD points.
class LodCheck {
 public:
  /// @param box  of the LOD's node. @param stored_steps  the error that the store gives.
  /// @param original  triangles below the node. @param seed  of points.
  LodCheck(const Mesh& lod, const LatticeBox& box, float stored_steps, uint64_t original, uint64_t seed);

  /// Thread safe.
  void add(const LeafSurface& leaf);
  /// After the last leaf: lattice steps; at least 3/4 of the stored error, below which nothing is told apart.
  /// Of an LOD that strays farther than 1.25 times that, 1.3 times or more.
  float found() const { return std::max(forward_, backward()); }

 private:
  LodCheck(const NodeMesh& lod, const LatticeBox& box, float stored_steps);
  float backward() const;
  void placePoints(const Mesh& lod, uint64_t count, Dice dice);
  void sortPoints();
  float farthestOf(const LeafSurface& leaf) const;
  void bringNearer(const LeafSurface& leaf);
  glm::ivec3 cellOf(glm::vec3 point) const;

  const glm::uvec3 origin_;
  const float stored_;
  const TriangleTree tree_;
  const SurfaceWalk walk_;         ///< shortens searches of the tree
  std::vector<glm::vec3> points_;  ///< of the LOD's surface, cell by cell
  std::vector<std::atomic<float>> nearest_;
  std::vector<uint32_t> begin_;  ///< of each cell's points, and the end
  int cells_ = 1;                ///< along each axis
  glm::vec3 cell_size_{1};
  std::mutex mutex_;
  float forward_ = 0;  ///< the largest distance of the leaves from the LOD
};

/// Looks for the largest distance between the boundaries of a node's LODs and those of the leaves below it,
/// which come one by one in any order, on any threads. What the node shares with its neighbours counts as a
/// boundary of both and is the same in both.
class BoundaryCheck {
 public:
  /// Before the first leaf. The LODs are numbered in the order of these calls.
  void addLod(const Mesh& lod);
  /// Thread safe. @param boundaries  of a leaf.
  void addLeaf(std::span<const store::OpenEdge> boundaries);
  /// After the last leaf: for each LOD what points of its boundaries are at most from the leaves', lattice
  /// steps.
  std::vector<float> found();

 private:
  std::mutex mutex_;
  store::OpenEdges of_leaves_;
  std::vector<std::vector<store::OpenEdge>> of_lods_;
};

}  // namespace lode::ingest
