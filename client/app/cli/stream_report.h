#pragma once

#include <nlohmann/json.hpp>

#include "client/core/engine.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// What limited a run, for --json: how long it was waited for what, what the most, and what is known of the
/// link.
void reportLimits(nlohmann::ordered_json& json, const core::EngineCounts& counts);

/// What cannot be had of a view, and why.
void reportGaps(nlohmann::ordered_json& json, const stream::StreamStatus& status);

/// What was asked for ahead of the camera, and what came of it.
nlohmann::ordered_json prefetchReport(const core::PrefetchCounts& counts);

}  // namespace lode::app
