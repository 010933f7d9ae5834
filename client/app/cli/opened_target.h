#pragma once

#include <chrono>
#include <optional>

#include "client/app/cli/child_server.h"
#include "client/app/cli/common_options.h"
#include "client/core/view/camera_path.h"
#include "client/core/view/framing.h"
#include "client/stream/streamer.h"

namespace lode::app {

/// What --camera names; nothing if it was not given. @throws Error as core::readCameraPath().
std::optional<core::CameraPath> wantedPath(const CommonOptions& options);

/// The target of a command, open, and the path along which it is looked at.
class OpenedTarget {
 public:
  using Clock = std::chrono::steady_clock;

  /// Reads the camera's path, resolves the target and waits until its model is open.
  /// @param announce  see resolveTarget(). @throws Error.
  OpenedTarget(const CommonOptions& options, const stream::StreamOptions& stream_options, bool announce);

  stream::Streamer& streamer() noexcept { return streamer_; }
  const ModelSummary& model() const noexcept { return model_; }
  /// The one that was asked for, or the camera that frames the model.
  const core::CameraPath& path() const noexcept { return path_; }
  /// Which way is up in the model: --up, or guessed from its coarsest mesh, which it may wait for.
  glm::dvec3 up();
  /// When the connection was begun: a build or a child server's start does not count.
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
