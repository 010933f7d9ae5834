#pragma once

#include <cstdint>
#include <vector>

#include "server/ingest/nodes/built_tree.h"
#include "server/ingest/nodes/node_builder.h"
#include "server/ingest/nodes/treelet_folder.h"
#include "server/ingest/nodes/treelet_plan.h"
#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

/// Resources for building a tree.
struct TreeResources {
  unsigned threads = 1;
  /// Memory for the nodes being built, for built nodes that wait for their parents, and for the tree itself.
  uint64_t memory_bytes = 0;
};

/// A tree to build, and the files for it.
struct TreeWork {
  const TreePlan& tree;
  const TreeletPlan& treelets;
  /// For each treelet, true if it is wanted. All treelets below a wanted one are wanted, or finished.
  std::vector<bool> is_wanted;
  TreeletFolder& folder;           ///< finished treelets; buildTree() adds the others
  const TemporaryFolder& scratch;  ///< folder for LODs of large nodes
};

/// Builds and encodes the wanted nodes on several threads, children before parents. Takes over the treelets
/// that are finished already, and writes each other treelet to the folder as soon as it is finished. A built
/// node keeps its coarsest LOD in memory until its parent is built. To hold few such LODs, an inner node is
/// built as soon as its children are built: about the nodes beside one path from a leaf to the root are then
/// in memory. A node waits if it does not fit into memory beside the nodes being built. The calling thread
/// reports progress. Adds the nodes of all wanted treelets to `built`. Throws the first error of any thread.
void buildTree(const NodeBuilder::Settings& settings, const Partition& partition, const TreeWork& work,
               const TreeResources& resources, const BuildProgress& progress, BuiltTree& built);

}  // namespace lode::ingest
