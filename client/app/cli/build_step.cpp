#include "client/app/cli/build_step.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/byte_size.h"

namespace lode::app {
namespace {

constexpr std::chrono::seconds kLogInterval{5};
constexpr double kSecondsUntil = 100;  ///< from this time on, texts show minutes
constexpr double kMinutesUntil = 100;  ///< from this time on, texts show hours

std::string timeInWords(double seconds) {
  if (seconds < kSecondsUntil) return std::to_string(std::lround(seconds)) + " s";
  const double minutes = seconds / 60;
  if (minutes < kMinutesUntil) return std::to_string(std::lround(minutes)) + " min";
  return std::to_string(std::lround(std::min(minutes / 60, 1e6))) + " h";
}

/// A power of 1000 with its name.
struct Scale {
  double factor;
  const char* name;
};

Scale scaleOf(double count) {
  if (count >= 1e9) return {1e9, " billion"};
  if (count >= 1e6) return {1e6, " million"};
  return count >= 1e4 ? Scale{1e3, " thousand"} : Scale{1, ""};
}

std::string scaled(double count, const Scale& scale) {
  char text[32];
  std::snprintf(text, sizeof text, scale.factor >= 1e6 ? "%.1f" : "%.0f", count / scale.factor);
  return text;
}

std::string bytesInWords(double bytes) { return describeBytes(static_cast<uint64_t>(std::min(bytes, 1e18))); }

/// Returns ": 1.2 of 2.0 million triangles, 0.3 million a second" without the numbers that are unknown.
std::string amountInWords(const BuildStep& step) {
  if (step.total <= 0) return "";
  const bool is_bytes = step.unit == "B";
  const Scale scale = scaleOf(step.total);
  std::string words =
      is_bytes ? bytesInWords(step.done) + " of " + bytesInWords(step.total)
               : scaled(step.done, scale) + " of " + scaled(step.total, scale) + scale.name + " " + step.unit;
  if (step.per_s > 0) {
    const Scale of_rate = step.per_s >= 0.1 * scale.factor ? scale : scaleOf(step.per_s);
    words += ", " + (is_bytes ? bytesInWords(step.per_s) : scaled(step.per_s, of_rate) + of_rate.name) +
             " a second";
  }
  return ": " + words;
}

}  // namespace

std::string stepInWords(const BuildStep& step) {
  return step.doing + amountInWords(step) +
         (step.seconds_left ? "; " + timeInWords(*step.seconds_left) + " left" : "");
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
