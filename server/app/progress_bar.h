#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

namespace lode::app {

/// Prints the progress of stages to a stream. kBar redraws a bar per stage on a terminal, with rate and time
/// left. kLines prints a line every few seconds. kJson prints JSON lines {"stage":NAME,"fraction":0..1} for
/// programs. The start of a stage ends the previous stage. Not thread safe.
class ProgressBar {
 public:
  enum class Mode { kQuiet, kLines, kBar, kJson };

  /// Returns kQuiet if quiet, kBar for a terminal, else kLines.
  static Mode modeFor(std::FILE* stream, bool quiet);

  ProgressBar(std::FILE* stream, Mode mode) : stream_(stream), mode_(mode) {}
  ~ProgressBar() { endLine(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Prints the progress of a stage if enough time has passed.
  /// @param fraction  completed part of the stage, 0 to 1. @param done  number of items done.
  void update(std::string_view stage, double fraction, uint64_t done);
  /// Prints the current stage as done and ends its line, so that other text can follow.
  void finishStage();

 private:
  using Clock = std::chrono::steady_clock;
  void endLine();
  void draw(Clock::time_point now);

  std::FILE* stream_;
  Mode mode_;
  std::string stage_;
  Clock::time_point stage_start_, last_drawn_;
  double fraction_ = 0, drawn_fraction_ = 0;
  uint64_t done_ = 0;
};

/// Formats a line of progress: "simplify  [=====>    ]  52 %  1.2 M  340 k/s  0:07 left". Omits the bar if
/// `bar_width` is 0.
std::string describeProgress(std::string_view stage, double fraction, uint64_t done, double seconds,
                             int bar_width);

}  // namespace lode::app
