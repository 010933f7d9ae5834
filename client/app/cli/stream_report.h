#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "client/app/cli/common_options.h"
#include "client/core/engine.h"
#include "client/stream/streamer.h"
#include "common/codec/model_summary.h"

namespace lode::app {

/// Adds the reasons for waiting to the output of --json: the waiting time by cause, the main cause, and
/// measurements of the link.
void reportLimits(nlohmann::ordered_json& json, const core::EngineCounts& counts);

/// Adds two members to the output of --json: the number of texture tiles that cannot be loaded, and the
/// reason for a failure, if any.
void reportGaps(nlohmann::ordered_json& json, const stream::StreamStatus& status);

/// Returns the statistics of prefetching as --json prints them.
nlohmann::ordered_json prefetchReport(const core::PrefetchCounts& counts);

/// Returns true if the cut of the view that was set last has converged and no visible texture tile is lost. A
/// view that shows the original triangles has converged, even if the eye is so near that a lattice step
/// exceeds the error threshold.
bool hasConverged(const stream::StreamStatus& status);

/// Returns true if the cut shows the store of a preview: the finest LOD of the only node is further from the
/// original surface than rounding to the lattice explains.
bool showsPreview(const stream::StreamStatus& status, const ModelSummary& model);

/// Throws an Error with the reason why a view did not converge, and the remedy.
/// @param where  name of the view for the message, for example "key 2".
[[noreturn]] void refuseUnconverged(const std::string& where, const stream::StreamStatus& status,
                                    const CommonOptions& options);

/// Warns on stderr if a converged view lacks parts that the server cannot deliver, or texture tiles that do
/// not fit into the memory budget.
void warnOfGaps(const stream::StreamStatus& status, const CommonOptions& options);

}  // namespace lode::app
