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
  uint64_t memory_bytes =
      0;  ///< for nodes being built, built nodes waiting for their parents, and the tree itself
};

/// Builds all nodes on several threads, children before parents, including encoding, and leaves them in
/// `nodes`. An inner node is built as soon as its children are, so only about one path of coarsest LODs is in
/// memory. A node that does not fit into memory with the current ones waits. The calling thread reports
/// progress and writes finished nodes to the log. Continues from the nodes in the log. Throws the first error
/// of any thread.
/// @param folder  for LODs of large nodes.
void buildTree(const NodeBuilder::Settings& settings, const Partition& partition, PayloadSpool& payloads,
               const TemporaryFolder& folder, SimplifyLog& log, NodeSpool& nodes,
               const TreeResources& resources, const BuildProgress& progress);

}  // namespace lode::ingest
