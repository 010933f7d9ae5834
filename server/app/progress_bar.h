#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

namespace lode::app {

/// Says on a stream how far each stage is: on a terminal a bar a stage, redrawn in place, with rate and time
/// left; elsewhere a line every few seconds; for programs
/// {"stage":NAME,"fraction":0..1} a line. A stage whose next one begins is done. One thread at a time.
class ProgressBar {
 public:
  enum class Mode { kQuiet, kLines, kBar, kJson };

  /// A bar if the stream is a terminal, else lines; nothing at all if quiet.
  static Mode modeFor(std::FILE* stream, bool quiet);

  ProgressBar(std::FILE* stream, Mode mode) : stream_(stream), mode_(mode) {}
  ~ProgressBar() { endLine(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// @param fraction  of the stage, 0..1.  @param done  its items so far.
  void update(std::string_view stage, double fraction, uint64_t done);
  /// Says that the last stage is done, and ends its line, so that other text can follow.
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

/// One line of progress: "simplify  [=====>    ]  52 %  1.2 M  340 k/s  0:07 left"; without the bar if
/// `bar_width` is 0.
std::string describeProgress(std::string_view stage, double fraction, uint64_t done, double seconds,
                             int bar_width);

}  // namespace lode::app
