#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "client/app/cli/target.h"
#include "client/core/engine.h"
#include "client/core/view/camera_path.h"
#include "client/stream/streamer.h"
#include "common/codec/blob.h"
#include "common/io/atomic_file.h"

namespace lode::app {

/// A request, and the time at which a client with an infinitely fast link would send it.
struct TracedRequest {
  double t_s = 0;  ///< seconds since the camera started along its path
  core::Request request;
  std::optional<core::DecodeJob> decode;  ///< job that decodes the blob, without the bytes; empty for pages
};

/// The requests along a camera path, in order of time. A trace is recorded once, and any number of clients
/// can replay it.
struct RequestTrace {
  Digest build_id;  ///< build of the model; blob numbers differ between builds
  double duration_s = 0;
  std::vector<TracedRequest> requests;
  std::string gap;  ///< reason why a part could not be loaded; empty if the trace is complete
};

/// Returns the camera path of a client for a model.
using PathOf = std::function<core::CameraPath(const ModelSummary&)>;

/// Checks that a trace was recorded from this build of the model.
/// @param source  name of the trace in the error message. @throws Error kInput if the trace is from another
/// build.
void checkBuild(const RequestTrace& trace, const Digest& build_id, const std::string& source);

/// Records a trace. Follows a path in steps of a tenth of a second, and waits at each step until the cut has
/// settled.
/// @throws the errors of a Session, for example kNetwork; kTimeout if recording takes too long.
RequestTrace recordTrace(const stream::ServedModel& model, const stream::StreamOptions& options,
                         const PathOf& path_of, glm::uvec2 size_px, float pixels,
                         std::chrono::milliseconds timeout);

constexpr uint64_t kMaxTraceFileBytes = 256ull << 20;
constexpr size_t kMaxTracedRequests = 1'000'000;

/// Version of the file format. Files of version 1 have neither a version nor a build_id.
constexpr uint32_t kTraceVersion = 2;

/// Formats a trace as JSON: {"version": 2, "build_id": "<32 hexadecimal digits>", "duration_s": 20, "step":
/// 0.001, "requests": [{"t": 0, "blob": 7, "bytes": 900, "name":
/// "<32 hexadecimal digits>", "class": 0, "px": 8.5, "mesh": {"triangles": 90, "vertices": 60, "attributes":
/// 1, "box": [0, 0, 0, 9, 9, 9]} or "tile": {"size": [512, 512], "tail": 0} or neither for pages}]}.
std::string toJson(const RequestTrace& trace);

/// Parses a trace. @param source  name that error messages give to the text.
/// @throws Error kInput or kLimit; the message names the request and the remedy.
RequestTrace parseRequestTrace(std::string_view json, std::string_view source);

/// Writes a trace into a file and commits the file. @throws Error kIo.
void writeRequestTrace(AtomicFile file, const RequestTrace& trace);
RequestTrace readRequestTrace(const std::filesystem::path& file);

}  // namespace lode::app
