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

/// Returns the framing that --up and --size request. @throws Error kUsage.
core::Framing wantedFraming(const CommonOptions& options);

/// Returns the framing of a scene: --size and the scene's up axis; wantedFraming() for a single model.
/// @throws Error kUsage if --up is given for a scene that names its own up axis.
core::Framing framingOf(const Scene& scene, const CommonOptions& options);

/// Adds the coarsest mesh of an open model to a framing. Waits for it; after the timeout or a stop request
/// the framing has none.
core::Framing frameCoarsely(core::Framing framing, stream::Streamer& streamer, const ModelSummary& model,
                            std::chrono::milliseconds timeout, const std::stop_token& stop = {});

/// Reads the file of --camera; returns nothing without the option. @throws Error as core::readCameraPath().
std::optional<core::CameraPath> wantedPath(const CommonOptions& options);

/// The open target of a command, and its camera path.
class OpenedTarget {
 public:
  using Clock = std::chrono::steady_clock;

  /// Reads the camera path, resolves the target and waits until its model is open.
  /// @param announce  see resolveTarget(). @throws Error.
  OpenedTarget(const CommonOptions& options, const stream::StreamOptions& stream_options, bool announce);

  stream::Streamer& streamer() noexcept { return streamer_; }
  const ModelSummary& model() const noexcept { return model_; }
  /// Returns the path of --camera, or the camera that frames the model.
  const core::CameraPath& path() const noexcept { return path_; }
  /// Returns the up direction: --up, or a guess from the coarsest mesh, for which it may wait.
  glm::dvec3 up();
  /// Returns the start of the connection, after a build and the start of a child server.
  Clock::time_point start() const noexcept { return start_; }
  core::View viewAt(double t, const PictureSize& size) const;

 private:
  void frame();

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
