#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "client/app/cli/target.h"
#include "client/core/engine.h"
#include "client/core/view/camera_path.h"
#include "client/stream/streamer.h"
#include "common/codec/blob.h"

namespace lode::app {

/// A request, at the time at which a client makes it whose link takes no time.
struct TracedRequest {
  double t_s = 0;  ///< from the path's beginning
  core::Request request;
  std::optional<core::DecodeJob> decode;  ///< without bytes: how to decode the blob; none of pages
};

/// What a camera path requests, in the order of time: recorded once, replayed by any number of clients.
struct RequestTrace {
  Digest build_id;  ///< of the model: in another build of it blobs have other numbers
  double duration_s = 0;
  std::vector<TracedRequest> requests;
  std::string gap;  ///< why it has no request a part that cannot be had; empty: it has all
};

/// The path that a client goes along, once it knows the model.
using PathOf = std::function<core::CameraPath(const ModelSummary&)>;

/// @param source  names the trace. @throws Error kInput if it is not of this build of the model.
void checkBuild(const RequestTrace& trace, const Digest& build_id, const std::string& source);

/// Goes along a path in steps of a tenth of a second, waiting at each until nothing more is to come.
/// @throws Error kNetwork and so on as a Session does, kTimeout.
RequestTrace recordTrace(const stream::ServedModel& model, const stream::StreamOptions& options,
                         const PathOf& path_of, glm::uvec2 size_px, float pixels,
                         std::chrono::milliseconds timeout);

}  // namespace lode::app
