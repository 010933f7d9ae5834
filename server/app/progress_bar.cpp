#include "server/app/progress_bar.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <utility>

#include <unistd.h>

#include "server/app/json_output.h"

namespace lode::app {
namespace {

constexpr int kBarWidth = 24, kBuildBarWidth = 10;
constexpr std::chrono::milliseconds kRedrawEvery{100};
constexpr std::chrono::seconds kLineEvery{5};

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

std::string barOf(double fraction, int width) {
  const auto filled = static_cast<int>(fraction * width);
  return '[' + std::string(static_cast<size_t>(filled), '=') + (filled < width ? ">" : "") +
         std::string(static_cast<size_t>(std::max(0, width - filled - 1)), ' ') + ']';
}

std::string percentOf(double fraction) {
  std::array<char, 16> percent{};
  std::snprintf(percent.data(), percent.size(), "%4.0f %%", std::floor(fraction * 100));
  return percent.data();
}

/// Formats a number with its unit, such as "1.2 M triangles" or "3.4 MB".
std::string describeItems(double count, std::string_view unit) {
  std::string text = describeCount(count);
  const bool has_prefix = !text.empty() && std::isalpha(static_cast<unsigned char>(text.back())) != 0;
  if (unit != "B" || !has_prefix) text += ' ';
  return text.append(unit);
}

}  // namespace

std::string describeProgress(std::string_view stage, double fraction, uint64_t done, double seconds,
                             int bar_width) {
  fraction = std::clamp(std::isfinite(fraction) ? fraction : 0.0, 0.0, 1.0);
  std::string line(stage);
  line.resize(std::max<size_t>(line.size(), 12), ' ');
  if (bar_width > 0) line += barOf(fraction, bar_width);
  line += percentOf(fraction);
  if (done > 0) line += "  " + describeCount(static_cast<double>(done));
  if (done > 0 && seconds > 0.1) line += "  " + describeCount(static_cast<double>(done) / seconds) + "/s";
  if (fraction >= 1)
    line += "  " + describeSeconds(seconds);
  else if (fraction > 0.01 && seconds > 0.5)
    line += "  " + describeSeconds(seconds * (1 - fraction) / fraction) + " left";
  return line;
}

std::string describeBuild(const ingest::BuildStatus& status, double seconds, int bar_width) {
  std::string line(status.doing);
  line.resize(std::max<size_t>(line.size(), 19), ' ');
  if (bar_width > 0) line += barOf(status.fraction, bar_width);
  line += percentOf(status.fraction);
  if (status.done > 0) {
    const bool has_total = bar_width == 0 && status.total > 0;
    line += "  " + (has_total ? describeCount(status.done) + " of " + describeItems(status.total, status.unit)
                              : describeItems(status.done, status.unit));
  }
  if (status.items_per_s > 0) line += "  " + describeCount(status.items_per_s) + "/s";
  if (status.fraction >= 1)
    line += "  " + describeSeconds(seconds);
  else if (status.seconds_left && seconds > 0.5)
    line += "  " + describeSeconds(*status.seconds_left) + " left";
  return line;
}

ProgressBar::ProgressBar(std::FILE* stream, Mode mode, const std::optional<ingest::BuildEstimate>& build,
                         Now now)
    : stream_(stream),
      mode_(mode),
      build_(build),
      now_(std::move(now)),
      start_(now_()),
      last_drawn_(start_) {}

ProgressBar::Mode ProgressBar::modeFor(std::FILE* stream, bool quiet) {
  if (quiet) return Mode::kQuiet;
  return ::isatty(::fileno(stream)) != 0 ? Mode::kBar : Mode::kLines;
}

ProgressBar::Clock::duration ProgressBar::interval() const {
  return mode_ == Mode::kLines ? Clock::duration(kLineEvery) : Clock::duration(kRedrawEvery);
}

void ProgressBar::update(std::string_view stage, double fraction, uint64_t done, uint64_t total) {
  if (mode_ == Mode::kQuiet) return;
  const Clock::time_point now = now_();
  if (stage != stage_) {
    if (!build_ || mode_ == Mode::kJson) finishStage();
    stage_ = stage;
    stage_start_ = now;
    if (mode_ == Mode::kBar && !build_) last_drawn_ = now;
    if (mode_ == Mode::kJson) last_drawn_ = {};
  }
  fraction_ = fraction;
  done_ = done;
  if (build_)
    build_->update(stage, fraction, done, total, std::chrono::duration<double>(now - start_).count());
  if (now - last_drawn_ >= interval()) draw(now);
}

void ProgressBar::finish() {
  is_finished_ = true;
  finishStage();
}

void ProgressBar::finishStage() {
  const bool is_printed = mode_ == Mode::kJson && drawn_fraction_ >= 1;
  fraction_ = 1;
  if (!stage_.empty() && mode_ != Mode::kLines && !is_printed) draw(now_());
  endLine();
}

void ProgressBar::endLine() {
  if (mode_ == Mode::kBar && !stage_.empty()) std::fputc('\n', stream_);
  stage_.clear();
}

void ProgressBar::drawJson() {
  Json json = {{"stage", stage_}, {"fraction", std::clamp(fraction_, 0.0, 1.0)}};
  if (build_) {
    const ingest::BuildStatus status = build_->status();
    json["doing"] = status.doing;
    json["build_fraction"] = is_finished_ ? 1 : status.fraction;
    json["done"] = status.total > 0 ? Json(status.done) : Json();
    json["total"] = status.total > 0 ? Json(status.total) : Json();
    json["unit"] = status.unit;
    json["per_second"] = status.items_per_s > 0 ? Json(status.items_per_s) : Json();
    json["seconds_left"] = is_finished_ ? Json(0) : status.seconds_left ? Json(*status.seconds_left) : Json();
  }
  std::fprintf(stream_, "%s\n", json.dump().c_str());
}

std::string ProgressBar::line(Clock::time_point now) const {
  const bool has_bar = mode_ == Mode::kBar;
  if (build_) {
    ingest::BuildStatus status = build_->status();
    if (is_finished_) status.fraction = 1;
    return describeBuild(status, std::chrono::duration<double>(now - start_).count(),
                         has_bar ? kBuildBarWidth : 0);
  }
  const double seconds = std::chrono::duration<double>(now - stage_start_).count();
  return describeProgress(stage_, fraction_, done_, seconds, has_bar ? kBarWidth : 0);
}

void ProgressBar::draw(Clock::time_point now) {
  last_drawn_ = now;
  drawn_fraction_ = fraction_;
  constexpr const char* kClearToEnd = "\x1b[K";
  if (mode_ == Mode::kJson)
    drawJson();
  else if (mode_ == Mode::kBar)
    std::fprintf(stream_, "\r%s%s", line(now).c_str(), kClearToEnd);
  else
    std::fprintf(stream_, "%s\n", line(now).c_str());
  std::fflush(stream_);
}

}  // namespace lode::app
