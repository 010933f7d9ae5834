#pragma once

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/nodes/node_builder.h"

namespace lode::ingest {

/// A node with the places of its payloads, which are not numbered yet.
struct FinishedNode {
  Node node;
  std::vector<PayloadSpool::Place> payloads;  ///< one an LOD
};

void putFinishedNode(RecordWriter& record, const Node& node, std::span<const PayloadSpool::Place> payloads);
/// @throws Error kFormat, kLimit.
FinishedNode getFinishedNode(RecordReader& record);

/// All that a parent needs of a node.
void putBuiltNode(RecordWriter& record, const BuiltNode& built);
/// @throws Error kFormat, kLimit.
BuiltNode getBuiltNode(RecordReader& record);

}  // namespace lode::ingest
