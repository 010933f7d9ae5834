#include "client/app/cli/stream_report.h"

#include <array>

namespace lode::app {
namespace {

using Json = nlohmann::ordered_json;
using core::Waiting;

struct Cause {
  Waiting waiting;
  const char* name;
};
constexpr std::array<Cause, 3> kCauses{
    {{Waiting::kLink, "link"}, {Waiting::kDecode, "decode"}, {Waiting::kBudget, "budget"}}};

Json orNull(double value) { return value > 0 ? Json(value) : Json(); }

}  // namespace

void reportLimits(Json& json, const core::EngineCounts& counts) {
  Json waited;
  const char* most = nullptr;
  double longest_s = 0;
  for (const Cause& cause : kCauses) {
    const double seconds = std::chrono::duration<double>(counts.waited.of(cause.waiting)).count();
    waited[cause.name] = seconds;
    if (seconds <= longest_s) continue;
    longest_s = seconds;
    most = cause.name;
  }
  json["limited_by"] = most == nullptr ? Json() : Json(most);
  json["waited_s"] = std::move(waited);
  json["link"] = {{"bytes_per_s", orNull(counts.link_bytes_per_s)},
                  {"round_trip_ms", orNull(counts.round_trip_ms)},
                  {"window_bytes", orNull(static_cast<double>(counts.window_bytes))}};
}

void reportGaps(Json& json, const stream::StreamStatus& status) {
  json["tiles_lost"] = status.cut ? status.cut->lost_tiles : 0;
  json["failure"] = status.failure.empty() ? Json() : Json(status.failure);
}

Json prefetchReport(const core::PrefetchCounts& counts) {
  const uint64_t ended = counts.used + counts.unused;
  return {
      {"requested", counts.requested},
      {"used", counts.used},
      {"hit_rate", ended == 0 ? Json() : Json(static_cast<double>(counts.used) / static_cast<double>(ended))},
      {"wasted_bytes", counts.unused_bytes}};
}

}  // namespace lode::app
