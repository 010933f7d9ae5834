#pragma once

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/nodes/node_builder.h"

namespace lode::ingest {

/// Place of a payload in its treelet's file.
struct PayloadPlace {
  uint64_t offset = 0;
  uint32_t bytes = 0;
};

/// A finished node and the places of its payloads. The node's LODs have no blob numbers yet; they get them
/// when the store is written.
struct FinishedNode {
  Node node;
  std::vector<PayloadPlace> payloads;  ///< one place per LOD
};

void putFinishedNode(RecordWriter& record, const Node& node, std::span<const PayloadPlace> payloads);
/// @throws Error kFormat, kLimit.
FinishedNode getFinishedNode(RecordReader& record);

/// Writes a record of all data that a node's parent needs.
void putBuiltNode(RecordWriter& record, const BuiltNode& built);
/// @throws Error kFormat, kLimit.
BuiltNode getBuiltNode(RecordReader& record);

}  // namespace lode::ingest
