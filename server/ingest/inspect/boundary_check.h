#pragma once

#include <mutex>
#include <span>
#include <vector>

#include "common/mesh.h"
#include "server/store/open_edges.h"

namespace lode::ingest {

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
