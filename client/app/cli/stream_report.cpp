#include "client/app/cli/stream_report.h"

#include <array>
#include <cstdio>

#include "client/app/cli/remedy_words.h"
#include "common/error.h"

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
  json["failure"] = status.failure.empty() ? Json() : Json(withRemedy(status.failure, status.failure_remedy));
}

Json prefetchReport(const core::PrefetchCounts& counts) {
  const uint64_t ended = counts.used + counts.unused;
  return {
      {"requested", counts.requested},
      {"used", counts.used},
      {"hit_rate", ended == 0 ? Json() : Json(static_cast<double>(counts.used) / static_cast<double>(ended))},
      {"wasted_bytes", counts.unused_bytes}};
}

bool hasConverged(const stream::StreamStatus& status) {
  return status.current && status.cut && status.cut->converged && status.cut->lost_tiles == 0;
}

bool showsPreview(const stream::StreamStatus& status, const ModelSummary& model) {
  if (model.nodes != 1 || !status.cut || status.cut->parts.size() != 1) return false;
  const core::CutPart& part = status.cut->parts.front();
  return part.lod == 0 && static_cast<double>(part.error_model) > model.lattice.step;
}

void refuseUnconverged(const std::string& where, const stream::StreamStatus& status,
                       const CommonOptions& options) {
  const std::string what = options.target + " did not converge at " + where;
  const Error failed(ErrorCode::kNetwork, what + ": " + status.failure, status.failure_remedy);
  if (status.cut && status.cut->lost_tiles > 0 && !status.failure.empty()) throw failed;
  if (status.limited)
    throw Error(
        ErrorCode::kLimit,
        what +
            ": the memory budget is too small for this view; allow more with --memory-budget, or a larger " +
            "error with --pixels");
  if (!status.failure.empty()) throw failed;
  const std::string remedy = "; allow more with --timeout, or a larger error with --pixels";
  throw Error(ErrorCode::kTimeout,
              what + " within " + std::to_string(options.timeout().count()) + " ms" +
                  (status.trouble.empty() ? remedy : ": " + status.trouble),
              status.trouble_remedy);
}

void warnOfGaps(const stream::StreamStatus& status, const CommonOptions& options) {
  if (!status.failure.empty() && !status.exhausted)
    std::fprintf(stderr, "lodestream: %s: shown without an unavailable part: %s\n", options.target.c_str(),
                 withRemedy(status.failure, status.failure_remedy).c_str());
  if (status.counts.tiles_left_out > 0)
    std::fprintf(
        stderr,
        "lodestream: %s: textures are coarse or missing, because the memory budget had no room for %llu of "
        "their tiles; allow more with --memory-budget\n",
        options.target.c_str(), static_cast<unsigned long long>(status.counts.tiles_left_out));
}

}  // namespace lode::app
