#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "client/app/cli/common_options.h"
#include "client/app/cli/target.h"
#include "client/core/view/framing.h"
#include "client/stream/streamer.h"
#include "common/codec/model_summary.h"
#include "common/error.h"

namespace lode::app {

/// Opens a target beside the window's thread: builds a PLY, starts the child server of a file, connects. The
/// thread lives as long as this object, since a child process ends with the thread that started it.
class ModelOpener {
 public:
  /// @param framing  completed by the coarsest mesh, so that a first camera can be made of it.
  ModelOpener(Target target, stream::StreamOptions options, core::Framing framing,
              std::chrono::milliseconds timeout);
  ~ModelOpener();
  ModelOpener(const ModelOpener&) = delete;
  ModelOpener& operator=(const ModelOpener&) = delete;

  struct Progress {
    std::string phase;                     ///< what is being done,
    double part = -1;                      ///< and how much of it, 0 to 1; below: unknown
    stream::Streamer* streamer = nullptr;  ///< once the model is open; lives as long as the opener
    const ModelSummary* model = nullptr;
    core::Framing framing;
    std::vector<std::string> warnings;  ///< of a build
    std::optional<Error> error;
  };
  Progress progress() const;

 private:
  void run();
  void say(std::string phase, double part = -1);

  const Target target_;
  const stream::StreamOptions options_;
  const core::Framing framing_;
  const std::chrono::milliseconds timeout_;
  mutable std::mutex mutex_;
  std::condition_variable stop_;
  std::stop_source stopping_;
  Progress progress_;
  std::thread thread_;
};

}  // namespace lode::app
