#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace lode::app {

/// Progress of a build.
struct BuildStep {
  std::string doing;                   ///< current stage in a user's words, such as "simplifying"
  double fraction = 0;                 ///< finished part of the whole build, 0 to 1
  std::optional<double> seconds_left;  ///< empty while unknown
  double done = 0, total = 0;          ///< items of the stage, finished and all; 0: unknown
  double per_s = 0;                    ///< items finished per second; 0: unknown
  std::string unit = {};               ///< name of the items, such as "triangles"; "B": bytes
};

/// Receives the progress of a build. builtStore() calls the functions on its caller's thread.
struct BuildWatch {
  std::function<void(const BuildStep&)> on_step;  ///< receives the progress; empty: stderr shows it
  /// Receives a store to show until the build is finished. If empty, the build makes no preview.
  std::function<void(const std::filesystem::path& preview)> on_preview;
};

/// Describes a build's stage, progress, speed and remaining time: "simplifying: 1.2 of 2.0 million triangles,
/// 0.3 million a second; 12 s left".
std::string stepInWords(const BuildStep& step);
/// Returns a percentage without rounding up: "46 %".
std::string percentInWords(double fraction);

/// Chooses the steps of a build that a log shows: one every five seconds. Pure.
class BuildLog {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  explicit BuildLog(TimePoint now) noexcept : last_(now) {}
  /// Returns the text to print now, such as "46 %, simplifying; 12 s left", or nothing.
  std::optional<std::string> add(const BuildStep& step, TimePoint now);

 private:
  TimePoint last_;
};

}  // namespace lode::app
