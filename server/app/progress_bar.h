#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "server/ingest/pipeline/build_estimate.h"

namespace lode::app {

/// Prints the progress of stages to a stream, with rate and time left. kBar redraws a bar on a terminal: one
/// for the whole build, or one per stage if there is no estimate of a build. kLines prints a line every five
/// seconds, for files and the logs of containers. kJson prints JSON lines for programs: the stage, its
/// finished fraction, and the estimate for the build. The start of a stage ends the previous stage. Not
/// thread safe.
class ProgressBar {
 public:
  enum class Mode { kQuiet, kLines, kBar, kJson };
  using Clock = std::chrono::steady_clock;
  using Now = std::function<Clock::time_point()>;

  /// Returns kQuiet if quiet, kBar for a terminal, else kLines.
  static Mode modeFor(std::FILE* stream, bool quiet);

  /// @param build  estimate of the build that the stages belong to; empty if there is no such build.
  /// @param now    clock; tests pass their own.
  ProgressBar(std::FILE* stream, Mode mode, const std::optional<ingest::BuildEstimate>& build = {},
              Now now = &Clock::now);
  ~ProgressBar() { endLine(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Prints the progress of a stage if enough time has passed.
  /// @param fraction     completed part of the stage, 0 to 1.
  /// @param done, total  number of items done, and of all items of the stage; 0: unknown.
  void update(std::string_view stage, double fraction, uint64_t done, uint64_t total);
  /// Prints the current stage, or the build, as done and ends its line, so that other text can follow.
  void finish();

 private:
  void finishStage();
  void endLine();
  void draw(Clock::time_point now);
  void drawJson();
  std::string line(Clock::time_point now) const;
  Clock::duration interval() const;

  std::FILE* stream_;
  Mode mode_;
  std::optional<ingest::BuildEstimate> build_;
  Now now_;
  std::string stage_;
  Clock::time_point start_, stage_start_, last_drawn_;
  double fraction_ = 0, drawn_fraction_ = 0;
  uint64_t done_ = 0;
  bool is_finished_ = false;  ///< the build is done
};

/// Formats a line of progress: "simplify  [=====>    ]  52 %  1.2 M  340 k/s  0:07 left". Omits the bar if
/// `bar_width` is 0.
std::string describeProgress(std::string_view stage, double fraction, uint64_t done, double seconds,
                             int bar_width);

/// Formats a line of a build's progress. With a bar the line has at most 79 characters:
/// "simplifying        [====>     ]   52 %  1.0 M triangles  140 k/s  0:07 left". Without a bar it has the
/// number of all triangles too.
/// @param seconds  time since the build began, which is printed instead of the time left once the build is
///                 done.
std::string describeBuild(const ingest::BuildStatus& status, double seconds, int bar_width);

}  // namespace lode::app
