#pragma once

#include "common/codec/model_summary.h"
#include "server/ingest/nodes/node_spool.h"
#include "server/ingest/plan/build_options.h"
#include "server/ingest/textures/textures.h"
#include "server/store/writer.h"

namespace lode::ingest {

/// Tiles and texture set to a store, coarse levels first.
/// @param tiles  where they wait; null if there are none.
void packTextures(const StagedTextures& textures, const UvGrid& grid, const Spool* tiles,
                  store::Writer& writer);

/// Stage 6: payloads and hierarchy into one store, coarse nodes first, siblings together, a node's coarse
/// LODs first.
/// @param writer   of the store; it may have textures already.
/// @param summary  see store::Writer::finish. @param nodes  all of them; used up.
ModelSummary pack(store::Writer& writer, ModelSummary summary, NodeSpool& nodes, const PayloadSpool& payloads,
                  const BuildProgress& progress);

}  // namespace lode::ingest
