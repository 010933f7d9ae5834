#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

namespace lode::app {

/// Progress of a build.
struct BuildStep {
  std::string doing;                   ///< current stage in a user's words, such as "simplifying"
  double fraction = 0;                 ///< finished part of the whole build, 0 to 1
  std::optional<double> seconds_left;  ///< empty while unknown
};

/// Receives the progress of a build. builtStore() calls the function on the thread of its own caller.
using BuildWatch = std::function<void(const BuildStep&)>;

/// Describes what a build does and how long it will take: "simplifying; 12 s left".
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
