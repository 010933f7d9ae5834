#pragma once

#include "common/codec/model_summary.h"
#include "server/ingest/nodes/built_node_record.h"
#include "server/ingest/nodes/node_spool.h"
#include "server/ingest/plan/build_options.h"
#include "server/ingest/textures/textures.h"
#include "server/store/writer.h"

namespace lode::ingest {

/// Writes tiles and texture set to a store, coarse levels first.
/// @param tiles  encoded tiles; null if there are none.
void packTextures(const StagedTextures& textures, const UvGrid& grid, const Spool* tiles,
                  store::Writer& writer);

/// Removes far LODs, except the coarsest, whose error exceeds that of the parent's finest LOD: a view that
/// accepts them shows the parent instead, unless a nearer sibling forces the split. Below a parent whose
/// finest LOD is large, the limit is twice that error: views of a whole model have such siblings.
void removeRedundantFarLods(FinishedNode& finished, const Node& parent);

/// Writes payloads and hierarchy to a store: coarse nodes first, siblings together, each node's coarse LODs
/// first.
/// @param writer   may have textures already.
/// @param summary  see store::Writer::finish(). @param nodes  all nodes; emptied.
ModelSummary pack(store::Writer& writer, ModelSummary summary, NodeSpool& nodes, const PayloadSpool& payloads,
                  const BuildProgress& progress);

}  // namespace lode::ingest
