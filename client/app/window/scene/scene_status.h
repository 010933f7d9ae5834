#pragma once

#include <span>

#include "client/core/view/view.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// Status of one model's stream, and the view that the stream refines for.
struct ModelStatus {
  const stream::StreamStatus& stream;
  const core::View& view;  ///< view of the model's first instance
};

/// Combines the status of all streams of a scene into one. The combined status is settled, converged or ended
/// if all models are, and limited or exhausted if any model is. Its cut has no parts, and is null until each
/// model has a cut. The cut has the scene's view once each model's cut is for the model's current view. The
/// failure is the first permanent failure of a model, or else the first temporary one. The trouble is the
/// first trouble of a model. Pure.
/// @param models  all models that have instances.
stream::StreamStatus sceneStatus(std::span<const ModelStatus> models, const core::View& scene_view);

}  // namespace lode::app
