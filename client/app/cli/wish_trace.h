#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "client/app/cli/target.h"
#include "client/core/camera_path.h"
#include "client/core/engine.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// A wish, at the time at which a client makes it whose link takes no time.
struct TracedWish {
  double t_s = 0;  ///< from the path's beginning
  core::Wish wish;
  std::optional<core::DecodeJob> decode;  ///< without bytes: how to decode the blob; none of pages
};

/// What a camera path wishes for, in the order of time: recorded once, replayed by any number of clients.
struct WishTrace {
  double duration_s = 0;
  std::vector<TracedWish> wishes;
};

/// For who names no path: 20 seconds once around the model, half as far away in the end.
core::CameraPath orbit(const ModelSummary& model);

/// Goes along a path in steps of a tenth of a second, waiting at each until nothing is missing.
/// @param path  none: orbit(). @throws Error kNetwork and so on as a Session does, kTimeout.
WishTrace recordTrace(const stream::ServedModel& model, const stream::StreamOptions& options,
                      const std::optional<core::CameraPath>& path, glm::uvec2 size_px, float pixels,
                      std::chrono::milliseconds timeout);

}  // namespace lode::app
