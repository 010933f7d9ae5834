#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "client/app/cli/common_options.h"
#include "client/core/engine.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// Adds the limits of a run to the output of --json: the waiting time per cause, the main cause, and
/// properties of the link.
void reportLimits(nlohmann::ordered_json& json, const core::EngineCounts& counts);

/// Adds the number of lost tiles and the reason for a failure to the output of --json.
void reportGaps(nlohmann::ordered_json& json, const stream::StreamStatus& status);

/// Returns the statistics of prefetching as --json prints them.
nlohmann::ordered_json prefetchReport(const core::PrefetchCounts& counts);

/// Returns true if the cut has converged and no visible texture tile is lost. Original triangles have
/// converged even if a lattice step covers more pixels than requested.
bool hasConverged(const stream::StreamStatus& status);

/// Throws an Error with the reason why a view did not converge, and the remedy.
/// @param where  name of the view for the message, for example "key 2".
[[noreturn]] void refuseUnconverged(const std::string& where, const stream::StreamStatus& status,
                                    const CommonOptions& options);

/// Warns on stderr if a converged view lacks parts that the server cannot deliver, or texture tiles that do
/// not fit into the memory budget.
void warnOfGaps(const stream::StreamStatus& status, const CommonOptions& options);

}  // namespace lode::app
