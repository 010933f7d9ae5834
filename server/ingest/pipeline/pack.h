#pragma once

#include "common/codec/model_summary.h"
#include "server/ingest/nodes/built_node_record.h"
#include "server/ingest/nodes/built_tree.h"
#include "server/ingest/plan/build_options.h"
#include "server/ingest/textures/textures.h"
#include "server/store/writer.h"

namespace lode::ingest {

/// Writes the texture tiles and the texture set to a store, coarse levels first.
/// @param tiles  encoded tiles, or null if the model has no tiles.
void packTextures(const StagedTextures& textures, const UvGrid& grid, const Spool* tiles,
                  store::Writer& writer);

/// Removes redundant far LODs of a node, but never the coarsest one. A far LOD is redundant if its error
/// exceeds the error of the parent's finest LOD: a client that accepts this error draws the parent instead,
/// unless a sibling nearer to the eye needs more detail. If the parent's finest LOD is large, the limit is
/// twice its error, because even views of the whole model then include siblings at different distances.
void removeRedundantFarLods(FinishedNode& finished, const Node& parent);

/// Writes the payloads and the hierarchy to a store: coarse nodes first, siblings together, and the coarse
/// LODs of each node first.
/// @param writer   writer of the store; the store can contain textures already.
/// @param summary  see store::Writer::finish().
ModelSummary pack(store::Writer& writer, ModelSummary summary, BuiltTree& tree,
                  const BuildProgress& progress);

}  // namespace lode::ingest
