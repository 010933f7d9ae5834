#pragma once

#include <span>

#include "client/core/view/view.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// Status of one model's stream, and the view for which the stream refines.
struct ModelStatus {
  const stream::StreamStatus& stream;
  const core::View& view;  ///< view of the model's first instance
};

/// Combines the status of all streams of a scene into one. The combined cut has no parts. The combined cut is
/// null until each model has a cut. The combined cut has the scene's view once each model's cut is for the
/// model's current view. The combined status is settled, converged or ended if this is true for all models.
/// The failure comes from the first model with a failure, and the trouble from the first model with a
/// trouble. Pure.
/// @param models  all models that have instances.
stream::StreamStatus sceneStatus(std::span<const ModelStatus> models, const core::View& scene_view);

}  // namespace lode::app
