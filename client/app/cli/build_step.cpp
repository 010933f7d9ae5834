#include "client/app/cli/build_step.h"

#include <algorithm>
#include <cmath>

namespace lode::app {
namespace {

constexpr std::chrono::seconds kLogInterval{5};
constexpr double kSecondsUntil = 100;  ///< times are in minutes from here
constexpr double kMinutesUntil = 100;  ///< times are in hours from here

std::string timeInWords(double seconds) {
  if (seconds < kSecondsUntil) return std::to_string(std::lround(seconds)) + " s";
  const double minutes = seconds / 60;
  if (minutes < kMinutesUntil) return std::to_string(std::lround(minutes)) + " min";
  return std::to_string(std::lround(std::min(minutes / 60, 1e6))) + " h";
}

}  // namespace

std::string stepInWords(const BuildStep& step) {
  return step.doing + (step.seconds_left ? "; " + timeInWords(*step.seconds_left) + " left" : "");
}

std::string percentInWords(double fraction) {
  return std::to_string(std::lround(std::floor(100 * std::clamp(fraction, 0.0, 1.0)))) + " %";
}

std::optional<std::string> BuildLog::add(const BuildStep& step, TimePoint now) {
  if (now - last_ < kLogInterval) return std::nullopt;
  last_ = now;
  return percentInWords(step.fraction) + ", " + stepInWords(step);
}

}  // namespace lode::app
