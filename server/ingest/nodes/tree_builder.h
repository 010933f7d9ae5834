#pragma once

#include <cstdint>

#include "server/ingest/nodes/node_builder.h"
#include "server/ingest/nodes/node_spool.h"
#include "server/ingest/nodes/simplify_log.h"
#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

/// What a tree is built with.
struct TreeResources {
  unsigned threads = 1;
  uint64_t memory_bytes = 0;  ///< for nodes under way, those that wait for their parents, and the tree itself
};

/// Stage 4, with stage 5 (encode) inside: builds all nodes, children before parents, on threads, and leaves
/// them in `nodes`. An inner node is built as soon as its children are, so that only a path's worth of
/// coarsest LODs is held; a node for which there is no memory beside those under way waits for them. The
/// calling thread reports progress, notes finished nodes in the log, goes on from those that are there, and
/// throws what the first failing thread met.
/// @param folder  for LODs of large nodes.
void buildTree(const NodeBuilder::Settings& settings, const Partition& partition, PayloadSpool& payloads,
               const TemporaryFolder& folder, SimplifyLog& log, NodeSpool& nodes,
               const TreeResources& resources, const BuildProgress& progress);

}  // namespace lode::ingest
