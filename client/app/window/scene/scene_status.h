#pragma once

#include <span>

#include "client/core/view/view.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// What a scene's window asks of one of its models, and has of it.
struct ModelStatus {
  const stream::StreamStatus& stream;
  const core::View& view;  ///< of its first place
};

/// What the streams of a scene say together: its cut, without parts, once each model has one, with the view
/// of the scene once each is about that; settled, converged and ended once each is; failed where one has.
/// Pure.
/// @param models  those that stand somewhere.
stream::StreamStatus sceneStatus(std::span<const ModelStatus> models, const core::View& scene_view);

}  // namespace lode::app
