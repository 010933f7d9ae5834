#include "client/loadtest/load_report.h"

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

/// Describes latencies by their median and 99th percentile. Returns "none" if the histogram is empty.
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
  const LoadCounts& counts = result.counts;
  Json json{
      {"clients", options.clients}, {"seconds", options.seconds},        {"full", options.full},
      {"started", counts.started},  {"interrupted", result.interrupted}, {"seconds_run", result.seconds}};
  if (!options.full)
    for (const LoadPlan& plan : plans)
      json["traces"].push_back({{"model", net::toString(plan.model.address) + "/" + plan.model.model},
                                {"seconds", plan.trace.duration_s},
                                {"requests", plan.trace.requests.size()}});
  json["blobs"] = counts.blobs;
  json["bytes"] = counts.bytes;
  json["errors"] = counts.errorCount();
  json["errors_by_kind"] = Json::object();
  for (const auto& [code, count] : counts.errors) json["errors_by_kind"][nameOf(code)] = count;
  json["first_error"] = counts.first_error.empty() ? Json() : Json(counts.first_error);
  json["unanswered"] = counts.unanswered;
  json["moved"] = counts.moved;
  json["turned_away"] = counts.turned_away;
  json["lost"] = counts.lost;
  json["gave_up"] = counts.gave_up;
  json["failed_requests"] = counts.failed_requests;
  json["latency_ms"] = {{"visible", percentiles(counts.latency[0])},
                        {"margin", percentiles(counts.latency[1])},
                        {"prefetch", percentiles(counts.latency[2])}};
  json["first_image_ms"] = percentiles(counts.first_image);
  if (options.full) {
    json["converged_ms"] = percentiles(counts.converged);
    json["seconds_looked"] = counts.looked_s;
    json["seconds_far_off"] = counts.far_off_s;
  }
  json["cpu_seconds"] = cpu_seconds;
  return json;
}

std::string describe(const LoadOptions& options, const LoadResult& result) {
  const LoadCounts& counts = result.counts;
  std::string text = result.interrupted ? "interrupted after " + number(result.seconds) + " of " : "";
  text += number(options.seconds, 0) + " s: ";
  text += counts.started < options.clients
              ? std::to_string(counts.started) + " of " + counted(options.clients, "client") + " had begun"
              : counted(options.clients, "client");
  text += ", " + counted(counts.blobs, "blob");
  if (result.seconds > 0)
    text += ", " + number(static_cast<double>(counts.bytes) * 1e-6 / result.seconds) + " MB/s";
  text += "; visible requests: " + medianAndWorst(counts.latency[0]);
  text += "; first image: " + medianAndWorst(counts.first_image);
  if (options.full) {
    text += "; converged: " + medianAndWorst(counts.converged);
    if (counts.looked_s > 0)
      text += "; far off " + number(100 * counts.far_off_s / counts.looked_s) + " % of the time";
  }
  text += "; " + std::to_string(counts.unanswered) + " unanswered, " + counted(counts.lost, "connection") +
          " lost" + ", " + counted(counts.gave_up, "client") + " gave up, " +
          counted(counts.errorCount(), "error");
  if (counts.turned_away > 0) text += ", turned away " + counted(counts.turned_away, "time");
  return counts.first_error.empty() ? text : text + ", the first: " + counts.first_error;
}

void LiveLine::print(double seconds, const LoadCounts& now) {
  std::fprintf(stderr, "%4.0f s: %s, %llu blobs/s, %.1f MB/s, visible requests: %s, %llu lost, %s\n", seconds,
               counted(now.started, "client").c_str(),
               static_cast<unsigned long long>(now.blobs - last_.blobs),
               static_cast<double>(now.bytes - last_.bytes) * 1e-6,
               medianAndWorst(now.latency[0].since(last_.latency[0])).c_str(),
               static_cast<unsigned long long>(now.lost), counted(now.errorCount(), "error").c_str());
  last_ = now;
}

}  // namespace lode::app
