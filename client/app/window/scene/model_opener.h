#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "client/app/cli/built_store.h"
#include "client/app/cli/common_options.h"
#include "client/app/cli/target.h"
#include "client/core/view/framing.h"
#include "client/stream/streamer.h"
#include "common/codec/model_summary.h"
#include "common/error.h"

namespace lode::app {

/// Opens a target on its own thread: builds the store of a PLY file, starts the child server of a local file,
/// and connects. The thread lives as long as this object, because a child process ends with the thread that
/// started it. Thread safe.
class ModelOpener {
 public:
  /// @param framing   framing without a mesh; Progress::framing adds the coarsest mesh.
  /// @param previews  true to show the preview of a PLY file while its store is built.
  ModelOpener(Target target, stream::StreamOptions options, core::Framing framing,
              std::chrono::milliseconds timeout, bool previews);
  ~ModelOpener();
  ModelOpener(const ModelOpener&) = delete;
  ModelOpener& operator=(const ModelOpener&) = delete;

  struct Progress {
    std::string phase;                     ///< description for the user; empty once the model is open
    double part = -1;                      ///< finished fraction of the phase, 0 to 1; negative: unknown
    stream::Streamer* streamer = nullptr;  ///< null until the model is open; lives as long as the opener
    const ModelSummary* model = nullptr;   ///< null until the model is open; lives as long as the opener
    /// True while the model is a preview; `phase` and `part` then describe the build. The finished store
    /// replaces the preview in the same stream, and `model` changes.
    bool is_preview = false;
    core::Framing framing;              ///< framing of the first camera, with the coarsest mesh
    std::vector<std::string> warnings;  ///< warnings of the build
    std::optional<Error> error;         ///< set if the model cannot be opened
  };
  /// Returns the current progress. Never waits for the network.
  Progress progress() const;

 private:
  struct Opened;

  void run();
  void openTarget(std::optional<Opened>& opened);
  void buildAndOpen(const PlyFile& ply, std::optional<Opened>& opened);
  void replacePreview(Opened& opened, BuiltStore store);
  std::optional<ModelSummary> waitForStore(Opened& opened);
  void show(Opened& opened, bool is_preview);
  void report(std::string phase, double part = -1);
  void fail(const Error& error);

  const Target target_;
  const stream::StreamOptions options_;
  const core::Framing framing_;
  const std::chrono::milliseconds timeout_;
  const bool previews_;
  mutable std::mutex mutex_;
  std::condition_variable stop_;
  std::stop_source stopping_;
  Progress progress_;
  std::thread thread_;
};

/// Opens a target with a ModelOpener. While the target's server is unreachable, tries again every few
/// seconds. Not thread safe.
class RetryingOpener {
 public:
  /// @param previews  see ModelOpener.
  /// @param target, textures_folder  arguments of parseTarget(). An invalid target counts as a failed
  /// attempt.
  RetryingOpener(std::string target, std::filesystem::path textures_folder, stream::StreamOptions options,
                 core::Framing framing, std::chrono::milliseconds timeout, bool previews);

  /// Returns the current progress without waiting. The error of a failed attempt stays set until the model is
  /// open.
  const ModelOpener::Progress& poll();
  /// Returns true if an attempt is under way or planned.
  bool retries() const noexcept { return next_attempt_ || opener_; }
  bool targetIsServer() const noexcept { return target_is_server_; }

 private:
  using Clock = std::chrono::steady_clock;

  void begin();
  void fail(const Error& error);

  const std::string target_;
  const std::filesystem::path textures_folder_;
  const stream::StreamOptions options_;
  const core::Framing framing_;
  const std::chrono::milliseconds timeout_;
  const bool previews_;
  bool target_is_server_ = false;
  std::optional<ModelOpener> opener_;  ///< current attempt; empty between two attempts
  /// Time of the next attempt; empty during an attempt, and if another attempt cannot succeed.
  std::optional<Clock::time_point> next_attempt_;
  ModelOpener::Progress progress_;  ///< progress at the last poll
};

}  // namespace lode::app
