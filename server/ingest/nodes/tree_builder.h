#pragma once

#include <cstdint>

#include "server/ingest/nodes/node_builder.h"
#include "server/ingest/nodes/node_spool.h"
#include "server/ingest/nodes/simplify_log.h"
#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

/// Resources for building a tree.
struct TreeResources {
  unsigned threads = 1;
  /// Memory for the nodes being built, for built nodes that wait for their parents, and for the tree itself.
  uint64_t memory_bytes = 0;
};

/// Files that buildTree() reads and writes.
struct TreeFiles {
  PayloadSpool& payloads;         ///< receives the encoded LODs
  const TemporaryFolder& folder;  ///< folder for LODs of large nodes
  SimplifyLog& log;               ///< finished nodes; a resumed build continues from them
  NodeSpool& nodes;               ///< receives the nodes
};

/// Builds and encodes all nodes on several threads, children before parents, and adds them to files.nodes. A
/// built node keeps its coarsest LOD in memory until its parent is built. To hold few such LODs, an inner
/// node is built as soon as its children are built: about the nodes beside one path from a leaf to the root
/// are then in memory. A node waits if it does not fit into memory beside the nodes being built. The calling
/// thread reports progress and writes finished nodes to the log. Nodes that the log has from an interrupted
/// build are not built again. Throws the first error of any thread.
void buildTree(const NodeBuilder::Settings& settings, const Partition& partition, const TreeFiles& files,
               const TreeResources& resources, const BuildProgress& progress);

}  // namespace lode::ingest
