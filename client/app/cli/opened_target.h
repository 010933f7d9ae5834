#pragma once

#include <chrono>
#include <optional>
#include <stop_token>

#include "client/app/cli/child_server.h"
#include "client/app/cli/common_options.h"
#include "client/app/cli/scene_file.h"
#include "client/core/view/camera_path.h"
#include "client/core/view/framing.h"
#include "client/stream/streamer.h"
#include "common/codec/model_summary.h"

namespace lode::app {

/// Returns a framing for the default camera, with the up axis of --up and the aspect ratio of --size. @throws
/// Error kUsage.
core::Framing wantedFraming(const CommonOptions& options);

/// Returns a framing for the default camera of a scene, with the scene's up axis and the aspect ratio of
/// --size. For a single model, returns wantedFraming().
/// @throws Error kUsage if --up is given for a scene that names its own up axis.
core::Framing framingOf(const Scene& scene, const CommonOptions& options);

/// Adds the coarsest mesh of an open model to a framing. Waits for the mesh; after the timeout or a stop
/// request, returns the framing without a mesh.
core::Framing frameCoarsely(core::Framing framing, stream::Streamer& streamer, const ModelSummary& model,
                            std::chrono::milliseconds timeout, const std::stop_token& stop = {});

/// Reads the camera path of --camera. Returns nothing if the option is not given. @throws Error as
/// core::readCameraPath().
std::optional<core::CameraPath> wantedPath(const CommonOptions& options);

/// A command's target, whose model is open, and the command's camera path.
class OpenedTarget {
 public:
  using Clock = std::chrono::steady_clock;

  /// Reads the camera path, resolves the target and waits until the target's model is open.
  /// @param announce  true to print the progress of a build; see resolveTarget(). @throws Error.
  OpenedTarget(const CommonOptions& options, const stream::StreamOptions& stream_options, bool announce);

  stream::Streamer& streamer() noexcept { return streamer_; }
  const ModelSummary& model() const noexcept { return model_; }
  /// Returns true if the model is only a preview, because of --preview.
  bool isPreview() const noexcept { return target_.is_preview; }
  /// Returns the path of --camera, or else the default camera as a path with one key.
  const core::CameraPath& path() const noexcept { return path_; }
  /// Returns the up direction of --up, or else a guess from the coarsest mesh. May wait for this mesh.
  glm::dvec3 up();
  /// Returns the time at which the connection started, after any build and the start of any child server.
  Clock::time_point start() const noexcept { return start_; }
  core::View viewAt(double t, const PictureSize& size) const;

 private:
  void frame(std::chrono::milliseconds timeout);

  const std::chrono::milliseconds timeout_;
  const std::optional<core::CameraPath> wanted_path_;
  core::Framing framing_;
  bool is_framed_ = false;
  ResolvedTarget target_;
  Clock::time_point start_;
  stream::Streamer streamer_;
  ModelSummary model_;
  core::CameraPath path_;
};

}  // namespace lode::app
