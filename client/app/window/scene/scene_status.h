#pragma once

#include <span>

#include "client/core/view/view.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// Status of one model's stream, and the view that it refines for.
struct ModelStatus {
  const stream::StreamStatus& stream;
  const core::View& view;  ///< at its first instance
};

/// Combines the status of a scene's streams. The cut has no parts; it is null until each model has a cut, and
/// has the scene's view once each model's cut is for its view. Settled, converged and ended: all models are.
/// Failure and trouble: the first model's that has one. Pure.
/// @param models  models with instances.
stream::StreamStatus sceneStatus(std::span<const ModelStatus> models, const core::View& scene_view);

}  // namespace lode::app
