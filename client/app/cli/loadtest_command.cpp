#include "client/app/cli/loadtest_command.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "client/app/cli/child_server.h"
#include "client/app/cli/common_options.h"
#include "client/app/cli/load_test.h"
#include "client/app/cli/opened_target.h"
#include "client/app/cli/wish_trace.h"
#include "client/app/cli/wish_trace_file.h"
#include "common/error.h"

namespace lode::app {
namespace {

using Json = nlohmann::ordered_json;

struct LoadtestOptions {
  CommonOptions common;
  LoadOptions load;
  std::string trace_file;
  bool decode_off = false, json = false;
};

double cpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

Json percentiles(const LatencyHistogram& latency) {
  return {{"count", latency.count()},
          {"p50", latency.percentileMs(0.5)},
          {"p90", latency.percentileMs(0.9)},
          {"p99", latency.percentileMs(0.99)},
          {"max", latency.maxMs()}};
}

Json toJson(const LoadtestOptions& options, const WishTrace& trace, const LoadTally& tally,
            double cpu_seconds) {
  return {{"clients", options.load.clients},
          {"seconds", options.load.seconds},
          {"trace", {{"seconds", trace.duration_s}, {"wishes", trace.wishes.size()}}},
          {"blobs", tally.blobs},
          {"bytes", tally.bytes},
          {"errors", tally.errors},
          {"first_error", tally.first_error},
          {"unanswered", tally.unanswered},
          {"moved", tally.moved},
          {"lost", tally.lost},
          {"failed_wishes", tally.failed_wishes},
          {"latency_ms",
           {{"visible", percentiles(tally.latency[0])},
            {"margin", percentiles(tally.latency[1])},
            {"prefetch", percentiles(tally.latency[2])}}},
          {"first_image_ms", percentiles(tally.first_image)},
          {"cpu_seconds", cpu_seconds}};
}

void print(const LoadtestOptions& options, const LoadTally& tally) {
  std::printf(
      "%u clients, %.0f s: %llu blobs, %.1f MB/s; visible wishes %.1f ms (median), %.1f ms (p99); "
      "first image %.1f ms (p99); %llu unanswered, %llu connections lost, %llu errors%s%s\n",
      options.load.clients, options.load.seconds, static_cast<unsigned long long>(tally.blobs),
      static_cast<double>(tally.bytes) * 1e-6 / options.load.seconds, tally.latency[0].percentileMs(0.5),
      tally.latency[0].percentileMs(0.99), tally.first_image.percentileMs(0.99),
      static_cast<unsigned long long>(tally.unanswered), static_cast<unsigned long long>(tally.lost),
      static_cast<unsigned long long>(tally.errors), tally.first_error.empty() ? "" : ": ",
      tally.first_error.c_str());
}

void loadtest(const LoadtestOptions& options, int& exit_status) {
  const std::optional<core::CameraPath> path = wantedPath(options.common);
  const ResolvedTarget target =
      resolveTarget(parseTarget(options.common.target), options.common.streamOptions(), !options.json);
  const PictureSize size = options.common.size();
  LoadPlan plan;
  plan.model = target.served;
  plan.options = target.options;
  plan.route = stream::routeTo(plan.model, plan.options);
  plan.decode = !options.decode_off;
  plan.trace = options.trace_file.empty()
                   ? recordTrace(plan.model, plan.options, path, {size.width_px, size.height_px},
                                 options.common.pixels, options.common.timeout())
                   : readWishTrace(options.trace_file);
  const double cpu_before = cpuSeconds();
  const LoadTally tally = runLoadTest(plan, options.load);
  if (options.json)
    std::printf("%s\n", toJson(options, plan.trace, tally, cpuSeconds() - cpu_before).dump().c_str());
  else
    print(options, tally);
  exit_status = tally.errors == 0 ? 0 : 1;
}

}  // namespace

void declareLoadtest(CLI::App& program, int& exit_status) {
  CLI::App* command = program.add_subcommand(
      "loadtest", "Lets many clients replay what a camera path wishes for, and measures how late it comes");
  const auto options = std::make_shared<LoadtestOptions>();
  addCommonOptions(*command, options->common);
  command->add_option("--clients", options->load.clients, "independent clients")
      ->required()
      ->check(CLI::Range(1u, 100'000u));
  command->add_option("--seconds", options->load.seconds, "how long")
      ->check(CLI::Range(0.1, 86'400.0))
      ->capture_default_str();
  command->add_option("--threads", options->load.threads, "threads that step the clients")
      ->check(CLI::Range(1u, 64u))
      ->capture_default_str();
  command->add_option("--trace", options->trace_file, "what to wish for, as replay --record wrote it")
      ->check(CLI::ExistingFile)
      ->type_name("FILE");
  command->add_flag("--decode-off", options->decode_off, "check names of blobs, but decode none");
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options, &exit_status] { loadtest(*options, exit_status); });
}

}  // namespace lode::app
