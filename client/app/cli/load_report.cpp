#include "client/app/cli/load_report.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <string>

#include "client/net/address.h"
#include "common/printable.h"

namespace lode::app {
namespace {

using Json = nlohmann::ordered_json;

Json percentiles(const LatencyHistogram& latency) {
  if (latency.count() == 0)
    return {{"count", 0}, {"p50", nullptr}, {"p90", nullptr}, {"p99", nullptr}, {"max", nullptr}};
  return {{"count", latency.count()},
          {"p50", latency.percentileMs(0.5)},
          {"p90", latency.percentileMs(0.9)},
          {"p99", latency.percentileMs(0.99)},
          {"max", latency.maxMs()}};
}

std::string number(double value, int digits = 1) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  return text.data();
}

std::string milliseconds(const LatencyHistogram& latency, double part) {
  return number(latency.percentileMs(part)) + " ms";
}

/// Of requests or clients; "none" where there were none.
std::string medianAndWorst(const LatencyHistogram& latency) {
  if (latency.count() == 0) return "none";
  return milliseconds(latency, 0.5) + " (median), " + milliseconds(latency, 0.99) + " (p99)";
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

Json toJson(const LoadOptions& options, std::span<const LoadPlan> plans, const LoadResult& result,
            double cpu_seconds) {
  const LoadTally& tally = result.tally;
  Json json{
      {"clients", options.clients}, {"seconds", options.seconds},        {"full", options.full},
      {"started", tally.started},   {"interrupted", result.interrupted}, {"seconds_run", result.seconds}};
  if (!options.full)
    for (const LoadPlan& plan : plans)
      json["traces"].push_back({{"model", net::toString(plan.model.address) + "/" + plan.model.model},
                                {"seconds", plan.trace.duration_s},
                                {"requests", plan.trace.requests.size()}});
  json["blobs"] = tally.blobs;
  json["bytes"] = tally.bytes;
  json["errors"] = tally.errorCount();
  json["errors_by_kind"] = Json::object();
  for (const auto& [code, count] : tally.errors) json["errors_by_kind"][nameOf(code)] = count;
  json["first_error"] = tally.first_error.empty() ? Json() : Json(tally.first_error);
  json["unanswered"] = tally.unanswered;
  json["moved"] = tally.moved;
  json["turned_away"] = tally.turned_away;
  json["lost"] = tally.lost;
  json["gave_up"] = tally.gave_up;
  json["failed_requests"] = tally.failed_requests;
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

std::string describe(const LoadOptions& options, const LoadResult& result) {
  const LoadTally& tally = result.tally;
  std::string text = result.interrupted ? "interrupted after " + number(result.seconds) + " of " : "";
  text += number(options.seconds, 0) + " s: ";
  text += tally.started < options.clients
              ? std::to_string(tally.started) + " of " + counted(options.clients, "client") + " had begun"
              : counted(options.clients, "client");
  text += ", " + counted(tally.blobs, "blob");
  if (result.seconds > 0)
    text += ", " + number(static_cast<double>(tally.bytes) * 1e-6 / result.seconds) + " MB/s";
  text += "; visible requests: " + medianAndWorst(tally.latency[0]);
  text += "; first image: " + medianAndWorst(tally.first_image);
  if (options.full) {
    text += "; converged: " + medianAndWorst(tally.converged);
    if (tally.looked_s > 0)
      text += "; far off " + number(100 * tally.far_off_s / tally.looked_s) + " % of the time";
  }
  text += "; " + std::to_string(tally.unanswered) + " unanswered, " + counted(tally.lost, "connection") +
          " lost" + ", " + counted(tally.gave_up, "client") + " gave up, " +
          counted(tally.errorCount(), "error");
  if (tally.turned_away > 0) text += ", turned away " + counted(tally.turned_away, "time");
  return tally.first_error.empty() ? text : text + ", the first: " + tally.first_error;
}

void LiveLine::print(double seconds, const LoadTally& now) {
  std::fprintf(stderr, "%4.0f s: %s, %llu blobs/s, %.1f MB/s, visible requests: %s, %llu lost, %s\n", seconds,
               counted(now.started, "client").c_str(),
               static_cast<unsigned long long>(now.blobs - last_.blobs),
               static_cast<double>(now.bytes - last_.bytes) * 1e-6,
               medianAndWorst(now.latency[0].since(last_.latency[0])).c_str(),
               static_cast<unsigned long long>(now.lost), counted(now.errorCount(), "error").c_str());
  last_ = now;
}

}  // namespace lode::app
