#pragma once

#include <filesystem>

#include "common/model_summary.h"
#include "server/ingest/simplify.h"

namespace lode::ingest {

/// Stage 6: payloads and hierarchy into one store, coarse nodes first, siblings together, a node's coarse
/// rungs first.
/// @param summary  see store::Writer::finish.
ModelSummary pack(const std::filesystem::path& output, ModelSummary summary, SimplifiedTree tree,
                  const PayloadSpool& payloads, const BuildProgress& progress);

}  // namespace lode::ingest
