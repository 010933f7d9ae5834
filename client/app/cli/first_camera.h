#pragma once

#include <chrono>
#include <stop_token>

#include "client/app/cli/common_options.h"
#include "client/app/cli/scene_file.h"
#include "client/core/view/framing.h"
#include "client/stream/streamer.h"
#include "common/codec/model_summary.h"

namespace lode::app {

/// What --up and --size say of the first camera. @throws Error kUsage.
core::Framing wantedFraming(const CommonOptions& options);

/// Returns how a scene is framed first: --size and the scene's up axis; of a single model as wantedFraming().
/// @throws Error kUsage if --up is given for a scene that names its own up axis.
core::Framing framingOf(const Scene& scene, const CommonOptions& options);

/// wantedFraming() with the coarsest mesh of an open model, which comes before all else. Waits for it: where
/// it does not come in time, or stop is requested, the framing has none.
core::Framing frameCoarsely(core::Framing framing, stream::Streamer& streamer, const ModelSummary& model,
                            std::chrono::milliseconds timeout, const std::stop_token& stop = {});

}  // namespace lode::app
