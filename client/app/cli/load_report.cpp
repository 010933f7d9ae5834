#include "client/app/cli/load_report.h"

#include <cstdio>

namespace lode::app {
namespace {

using Json = nlohmann::ordered_json;

Json percentiles(const LatencyHistogram& latency) {
  return {{"count", latency.count()},
          {"p50", latency.percentileMs(0.5)},
          {"p90", latency.percentileMs(0.9)},
          {"p99", latency.percentileMs(0.99)},
          {"max", latency.maxMs()}};
}

const char* nameOf(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUsage:
      return "usage";
    case ErrorCode::kInput:
      return "input";
    case ErrorCode::kIo:
      return "io";
    case ErrorCode::kFormat:
      return "format";
    case ErrorCode::kLimit:
      return "limit";
    case ErrorCode::kNetwork:
      return "network";
    case ErrorCode::kProtocol:
      return "protocol";
    case ErrorCode::kTimeout:
      return "timeout";
    case ErrorCode::kInternal:
      break;
  }
  return "internal";
}

}  // namespace

Json toJson(const LoadOptions& options, std::span<const LoadPlan> plans, const LoadTally& tally,
            double cpu_seconds) {
  Json json{{"clients", options.clients},
            {"seconds", options.seconds},
            {"full", options.full},
            {"started", tally.started}};
  if (!options.full)
    json["trace"] = {{"seconds", plans[0].trace.duration_s}, {"wishes", plans[0].trace.wishes.size()}};
  json["blobs"] = tally.blobs;
  json["bytes"] = tally.bytes;
  json["errors"] = tally.errorCount();
  json["errors_by_kind"] = Json::object();
  for (const auto& [code, count] : tally.errors) json["errors_by_kind"][nameOf(code)] = count;
  json["first_error"] = tally.first_error;
  json["unanswered"] = tally.unanswered;
  json["moved"] = tally.moved;
  json["lost"] = tally.lost;
  json["failed_wishes"] = tally.failed_wishes;
  json["latency_ms"] = {{"visible", percentiles(tally.latency[0])},
                        {"margin", percentiles(tally.latency[1])},
                        {"prefetch", percentiles(tally.latency[2])}};
  json["first_image_ms"] = percentiles(tally.first_image);
  if (options.full) {
    json["converged_ms"] = percentiles(tally.converged);
    json["seconds_looked"] = tally.looked_s;
    json["seconds_far_off"] = tally.far_off_s;
  }
  json["cpu_seconds"] = cpu_seconds;
  return json;
}

void print(const LoadOptions& options, const LoadTally& tally) {
  std::printf(
      "%u clients, %.0f s: %llu blobs, %.1f MB/s; visible wishes %.1f ms (median), %.1f ms (p99); first "
      "image %.1f ms (p99)",
      options.clients, options.seconds, static_cast<unsigned long long>(tally.blobs),
      static_cast<double>(tally.bytes) * 1e-6 / options.seconds, tally.latency[0].percentileMs(0.5),
      tally.latency[0].percentileMs(0.99), tally.first_image.percentileMs(0.99));
  if (options.full)
    std::printf("; converged %.1f ms (median), %.1f ms (p99); far off %.1f %% of the time",
                tally.converged.percentileMs(0.5), tally.converged.percentileMs(0.99),
                tally.looked_s > 0 ? 100 * tally.far_off_s / tally.looked_s : 0.0);
  std::printf("; %llu unanswered, %llu connections lost, %llu errors%s%s\n",
              static_cast<unsigned long long>(tally.unanswered), static_cast<unsigned long long>(tally.lost),
              static_cast<unsigned long long>(tally.errorCount()), tally.first_error.empty() ? "" : ": ",
              tally.first_error.c_str());
}

void LiveLine::print(double seconds, const LoadTally& now) {
  std::fprintf(stderr,
               "%4.0f s: %llu clients, %llu blobs/s, %.1f MB/s, visible wishes %.1f ms (median), %.1f ms "
               "(p99), %llu lost, %llu errors\n",
               seconds, static_cast<unsigned long long>(now.started),
               static_cast<unsigned long long>(now.blobs - last_.blobs),
               static_cast<double>(now.bytes - last_.bytes) * 1e-6,
               now.latency[0].since(last_.latency[0]).percentileMs(0.5),
               now.latency[0].since(last_.latency[0]).percentileMs(0.99),
               static_cast<unsigned long long>(now.lost), static_cast<unsigned long long>(now.errorCount()));
  last_ = now;
}

}  // namespace lode::app
