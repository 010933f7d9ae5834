#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "client/app/window/scene/model_opener.h"

namespace lode::app {

/// Opens a target as ModelOpener does, and tries again every few seconds where its server is away. For the
/// window's thread.
class PatientOpener {
 public:
  /// @param target  as parseTarget() takes it; one that it refuses counts as failed.
  PatientOpener(std::string target, stream::StreamOptions options, std::chrono::milliseconds timeout);

  /// Looks how far it has come, without waiting. An error stays until the model is open.
  const ModelOpener::Progress& look();
  /// It has failed, and goes on by itself.
  bool triesAgain() const noexcept { return next_try_ || opener_; }
  /// Its target is no file.
  bool asksServer() const noexcept { return asks_server_; }

 private:
  using Clock = std::chrono::steady_clock;

  void begin();
  void fail(const Error& error);

  const std::string target_;
  const stream::StreamOptions options_;
  const std::chrono::milliseconds timeout_;
  bool asks_server_ = false;
  std::optional<ModelOpener> opener_;          ///< nothing between two tries
  std::optional<Clock::time_point> next_try_;  ///< nothing: there is no use in one
  ModelOpener::Progress progress_;             ///< the last
};

}  // namespace lode::app
