#include "client/loadtest/loadtest_command.h"

#include <array>
#include <atomic>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <sys/resource.h>
#include <unistd.h>

#include "client/app/cli/child_server.h"
#include "client/app/cli/common_options.h"
#include "client/app/cli/made_path.h"
#include "client/app/cli/opened_target.h"
#include "client/loadtest/load_report.h"
#include "client/loadtest/load_test.h"
#include "client/loadtest/request_trace.h"
#include "common/command_line.h"
#include "common/error.h"

namespace lode::app {
namespace {

/// Added to a signal's number to get the exit status after the signal, as in shells.
constexpr int kSignalled = 128;
constexpr uint64_t kTracesOfPlaces = 4;  ///< number of traces per target if paths depend on seeds

const std::map<std::string, MadePath> kMadePaths{
    {"orbit", MadePath::kOrbit}, {"fly", MadePath::kFly}, {"walk", MadePath::kWalk}};

struct LoadtestOptions {
  CommonOptions common;
  LoadOptions load;
  std::vector<std::string> more_targets;
  std::string made_path = "orbit";
  double fps = 10, think_s = 0;
  std::optional<double> ramp_s;
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

constexpr std::array kSignals{SIGINT, SIGTERM};
std::atomic<int> signal_that_came{0};
static_assert(std::atomic<int>::is_always_lock_free);

/// Handles SIGINT and SIGTERM while an object of this class exists. The first signal does not end the
/// process; signal() reports it, so that the test can end early and print its results. A second signal ends
/// the process. At most one object may exist at a time.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// Returns the number of the signal that has arrived; 0 if none has. Thread safe.
  static int signal() noexcept;

 private:
  std::array<struct sigaction, 2> before_{};
};

Interruption::Interruption() {
  signal_that_came = 0;
  struct sigaction action {};
  action.sa_handler = [](int number) { signal_that_came = number; };
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  for (size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &action, &before_[i]);
}

Interruption::~Interruption() {
  for (size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

int Interruption::signal() noexcept { return signal_that_came; }

/// The plans of a load test, and their targets, which stay open as long as this object exists.
class PlannedLoad {
 public:
  explicit PlannedLoad(const LoadtestOptions& options) : options_(options) {
    const std::optional<core::CameraPath> recorded = wantedPath(options.common);
    path_of_ = [recorded, kind = kMadePaths.at(options.made_path)](const ModelSummary& model, uint64_t seed) {
      return recorded ? *recorded : makePath(kind, model, seed);
    };
    const bool places_differ = !recorded && options.made_path != "orbit";
    traces_ = options.load.full || !options.trace_file.empty() || !places_differ ? 1 : kTracesOfPlaces;
    std::vector<LoadPlan> of_targets{planOf(options.common.target)};
    for (const std::string& target : options.more_targets) of_targets.push_back(planOf(target));
    // Clients use the plans in this order, so that targets alternate.
    for (uint64_t seed = 0; seed < traces_; ++seed)
      for (size_t i = 0; i < of_targets.size(); ++i) {
        plans_.push_back(of_targets[i]);
        if (!options.load.full) plans_.back().trace = traceOf(targets_[i], of_targets[i], seed);
      }
  }

  std::span<LoadPlan> plans() noexcept { return plans_; }

 private:
  /// Opens a target. @return the plan of the target's clients, still without a trace.
  LoadPlan planOf(const std::string& target) {
    targets_.push_back(resolveTarget(parseTarget(target, options_.common.textures_folder),
                                     options_.common.streamOptions(), !options_.json));
    const ResolvedTarget& open = targets_.back();
    const PictureSize size = options_.common.size();
    LoadPlan plan;
    plan.model = open.served;
    plan.options = open.options;
    plan.options.engine.session.open_patience = options_.common.timeout();
    plan.route = stream::routeTo(plan.model, plan.options);
    plan.path_of = path_of_;
    plan.size_px = {size.width_px, size.height_px};
    plan.pixels = options_.common.pixels;
    plan.fps = options_.fps;
    plan.think_s = options_.think_s;
    plan.decode = !options_.decode_off;
    return plan;
  }

  RequestTrace readTrace(const ResolvedTarget& target) const {
    const RequestTrace trace = readRequestTrace(options_.trace_file);
    if (trace.requests.empty())
      throw Error(ErrorCode::kInput,
                  options_.trace_file +
                      ": the trace has no requests to replay; record a path that comes closer to "
                      "the model, or with a smaller error (--pixels)");
    stream::StreamOptions options = target.options;
    options.cache_folder.clear();
    stream::Streamer streamer(target.served, options);
    checkBuild(trace, openModel(streamer, target, options_.common.timeout()).build_id, options_.trace_file);
    return trace;
  }

  RequestTrace traceOf(const ResolvedTarget& target, const LoadPlan& plan, uint64_t seed) const {
    if (!options_.trace_file.empty()) return readTrace(target);
    const auto path_of = [&](const ModelSummary& model) { return path_of_(model, seed); };
    RequestTrace trace =
        recordTrace(plan.model, plan.options, path_of, plan.size_px, plan.pixels, options_.common.timeout());
    if (!trace.gap.empty())
      std::fprintf(stderr, "lodestream: %s: clients do not request an unavailable part: %s\n",
                   stream::toString(plan.model).c_str(), trace.gap.c_str());
    return trace;
  }

  const LoadtestOptions& options_;
  std::function<core::CameraPath(const ModelSummary&, uint64_t seed)> path_of_;
  uint64_t traces_ = 1;  ///< number of traces per target
  std::vector<ResolvedTarget> targets_;
  std::vector<LoadPlan> plans_;
};

void check(const LoadtestOptions& options) {
  if (!options.trace_file.empty() && (options.load.full || !options.more_targets.empty()))
    throw Error(ErrorCode::kUsage, "--trace works only with a single model and without --full; leave it out");
  if (!options.common.cache_text.empty() && options.common.cache_text != "off")
    throw Error(ErrorCode::kUsage, "clients of a load test keep no cache: leave out --cache");
  if (options.decode_off && options.load.full)
    throw Error(ErrorCode::kUsage, "full clients always decode; leave out --full or --decode-off");
}

void loadtest(const LoadtestOptions& options, int& exit_status) {
  check(options);
  PlannedLoad planned(options);
  LoadOptions load = options.load;
  load.ramp_s = options.ramp_s.value_or(load.seconds / 4);
  LiveLine live;
  if (isatty(STDERR_FILENO) == 1)
    load.progress = [&](double seconds, const LoadCounts& counts) { live.print(seconds, counts); };
  const Interruption interruption;
  load.is_stopped = [] { return Interruption::signal() != 0; };
  const double cpu_before = cpuSeconds();
  const LoadResult result = runLoadTest(planned.plans(), load);
  std::printf("%s\n", options.json
                          ? toJson(load, planned.plans(), result, cpuSeconds() - cpu_before).dump().c_str()
                          : describe(load, result).c_str());
  if (result.interrupted)
    exit_status = kSignalled + Interruption::signal();
  else if (!result.counts.errors.empty())
    throw Error(ErrorCode::kNetwork, "the load test had errors, " +
                                         std::to_string(result.counts.errorCount()) +
                                         " in all; the first: " + result.counts.first_error);
}

}  // namespace

void declareLoadtest(CLI::App& program, int& exit_status) {
  CLI::App* command = program.add_subcommand(
      "loadtest", "Runs many clients on camera paths and measures the latency of their requests");
  const auto options = std::make_shared<LoadtestOptions>();
  addCommonOptions(*command, options->common);
  command->remove_option(command->get_option("--up"));  // generated paths go around the y axis
  command->remove_option(command->get_option("--offline"));
  auto* camera = command->get_option("--camera");
  command->add_option("--clients", options->load.clients, "number of independent clients")
      ->required()
      ->check(CLI::Range(1u, 100'000u));
  command->add_option("--seconds", options->load.seconds, "duration of the test in seconds")
      ->check(numberFrom(0.1, 86'400.0))
      ->capture_default_str();
  command
      ->add_option("more", options->more_targets,
                   "further models, on any servers; clients use the models by turns")
      ->type_name("TARGET");
  auto* full = command->add_flag(
      "--full", options->load.full,
      "every client refines and decodes as a window does; otherwise clients replay recorded requests");
  auto* path = command->add_option("--path", options->made_path, "camera path if --camera is not given")
                   ->check(CLI::IsMember(kMadePaths))
                   ->capture_default_str()
                   ->excludes(camera);
  command
      ->add_option("--ramp", options->ramp_s,
                   "time in which the clients start, one after the other (default: a quarter of --seconds)")
      ->check(numberFrom(0.0, 86'400.0))
      ->type_name("SECONDS");
  command
      ->add_option("--think", options->think_s,
                   "mean pause at the end of the path, before the path starts again")
      ->check(numberFrom(0.0, 86'400.0))
      ->type_name("SECONDS")
      ->capture_default_str();
  command->add_option("--fps", options->fps, "views per second of a full client")
      ->check(numberFrom(0.1, 1000.0))
      ->needs(full)
      ->capture_default_str();
  command->add_option("--threads", options->load.threads, "number of threads that run the clients")
      ->check(CLI::Range(1u, 64u))
      ->capture_default_str();
  command
      ->add_option("--trace", options->trace_file,
                   "replay the requests of this file, which replay --record wrote")
      ->check(CLI::ExistingFile)
      ->type_name("FILE")
      ->excludes(camera)
      ->excludes(path)
      ->excludes(command->get_option("--size"))
      ->excludes(command->get_option("--pixels"));
  command->add_flag("--decode-off", options->decode_off,
                    "check the digests of blobs, but do not decode them");
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options, &exit_status] { loadtest(*options, exit_status); });
}

}  // namespace lode::app
