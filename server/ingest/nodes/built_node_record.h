#pragma once

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/nodes/node_builder.h"

namespace lode::ingest {

/// A node whose payloads have no blob numbers yet, with their places in the spool.
struct FinishedNode {
  Node node;
  std::vector<PayloadSpool::Place> payloads;  ///< one per LOD
};

void putFinishedNode(RecordWriter& record, const Node& node, std::span<const PayloadSpool::Place> payloads);
/// @throws Error kFormat, kLimit.
FinishedNode getFinishedNode(RecordReader& record);

/// Records of everything that a node's parent needs.
void putBuiltNode(RecordWriter& record, const BuiltNode& built);
/// @throws Error kFormat, kLimit.
BuiltNode getBuiltNode(RecordReader& record);

}  // namespace lode::ingest
