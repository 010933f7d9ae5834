#include "server/app/progress_bar.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <unistd.h>

#include "server/app/json_output.h"

namespace lode::app {
namespace {

constexpr int kBarWidth = 24;
constexpr std::chrono::milliseconds kRedrawEvery{100};
constexpr std::chrono::seconds kLineEvery{3};

std::string describeCount(double count) {
  constexpr std::array kUnits{"", " k", " M", " G"};
  size_t unit = 0;
  for (; count >= 1000 && unit + 1 < kUnits.size(); ++unit) count /= 1000;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), unit == 0 || count >= 100 ? "%.0f%s" : "%.1f%s", count,
                kUnits[unit]);
  return text.data();
}

std::string describeSeconds(double seconds) {
  const auto whole = static_cast<long>(std::ceil(std::min(seconds, 359999.0)));
  std::array<char, 32> text{};
  if (whole >= 3600)
    std::snprintf(text.data(), text.size(), "%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
  else
    std::snprintf(text.data(), text.size(), "%ld:%02ld", whole / 60, whole % 60);
  return text.data();
}

}  // namespace

std::string describeProgress(std::string_view stage, double fraction, uint64_t done, double seconds,
                             int bar_width) {
  fraction = std::clamp(std::isfinite(fraction) ? fraction : 0.0, 0.0, 1.0);
  std::string line(stage);
  line.resize(std::max<size_t>(line.size(), 12), ' ');
  if (bar_width > 0) {
    const auto filled = static_cast<int>(fraction * bar_width);
    line += '[' + std::string(static_cast<size_t>(filled), '=') + (filled < bar_width ? ">" : "") +
            std::string(static_cast<size_t>(std::max(0, bar_width - filled - 1)), ' ') + ']';
  }
  std::array<char, 16> percent{};
  std::snprintf(percent.data(), percent.size(), "%4.0f %%", fraction * 100);
  line += percent.data();
  if (done > 0) line += "  " + describeCount(static_cast<double>(done));
  if (done > 0 && seconds > 0.1) line += "  " + describeCount(static_cast<double>(done) / seconds) + "/s";
  if (fraction >= 1)
    line += "  " + describeSeconds(seconds);
  else if (fraction > 0.01 && seconds > 0.5)
    line += "  " + describeSeconds(seconds * (1 - fraction) / fraction) + " left";
  return line;
}

ProgressBar::Mode ProgressBar::modeFor(std::FILE* stream, bool quiet) {
  if (quiet) return Mode::kQuiet;
  return ::isatty(::fileno(stream)) != 0 ? Mode::kBar : Mode::kLines;
}

void ProgressBar::update(std::string_view stage, double fraction, uint64_t done) {
  if (mode_ == Mode::kQuiet) return;
  const Clock::time_point now = Clock::now();
  if (stage != stage_) {
    finishStage();
    stage_ = stage;
    stage_start_ = last_drawn_ = now;
    if (mode_ == Mode::kJson) last_drawn_ = {};
  }
  fraction_ = fraction;
  done_ = done;
  if (now - last_drawn_ >=
      (mode_ == Mode::kLines ? Clock::duration(kLineEvery) : Clock::duration(kRedrawEvery)))
    draw(now);
}

void ProgressBar::finishStage() {
  const bool is_printed = mode_ == Mode::kJson && drawn_fraction_ >= 1;
  fraction_ = 1;
  if (!stage_.empty() && mode_ != Mode::kLines && !is_printed) draw(Clock::now());
  endLine();
}

void ProgressBar::endLine() {
  if (mode_ == Mode::kBar && !stage_.empty()) std::fputc('\n', stream_);
  stage_.clear();
}

void ProgressBar::draw(Clock::time_point now) {
  last_drawn_ = now;
  drawn_fraction_ = fraction_;
  if (mode_ == Mode::kJson) {
    const Json json = {{"stage", stage_}, {"fraction", std::clamp(fraction_, 0.0, 1.0)}};
    std::fprintf(stream_, "%s\n", json.dump().c_str());
    std::fflush(stream_);
    return;
  }
  const double seconds = std::chrono::duration<double>(now - stage_start_).count();
  const bool bar = mode_ == Mode::kBar;
  const std::string line = describeProgress(stage_, fraction_, done_, seconds, bar ? kBarWidth : 0);
  constexpr const char* kClearToEnd = "\x1b[K";
  if (bar)
    std::fprintf(stream_, "\r%s%s", line.c_str(), kClearToEnd);
  else
    std::fprintf(stream_, "%s\n", line.c_str());
  std::fflush(stream_);
}

}  // namespace lode::app
