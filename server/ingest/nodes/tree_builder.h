#pragma once

#include <vector>

#include "server/ingest/nodes/node_builder.h"
#include "server/ingest/nodes/simplify_log.h"
#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

/// The finished tree: nodes in key order, and where their payloads wait.
struct SimplifiedTree {
  std::vector<Node> nodes;
  std::vector<std::vector<PayloadSpool::Place>> payloads;  ///< one list a node, one place a rung
};

/// A tree of which all nodes were finished before.
SimplifiedTree treeOf(FinishedNodes finished);

/// Stage 4, with stage 5 (encode) inside: builds all nodes, children before parents, on `threads` threads. An
/// inner node is built as soon as its children are, so that only a path's worth of coarsest rungs is held.
/// The calling thread reports progress, notes finished nodes in the log, goes on from those that are there,
/// and throws what the first failing thread met.
SimplifiedTree simplify(const NodeBuilder::Settings& settings, const Partition& partition,
                        PayloadSpool& payloads, SimplifyLog& log, unsigned threads,
                        const BuildProgress& progress);

}  // namespace lode::ingest
