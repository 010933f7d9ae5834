#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "client/app/cli/made_path.h"
#include "client/app/cli/opened_target.h"
#include "client/app/cli/stream_report.h"
#include "client/app/cli/target.h"
#include "client/core/lod/cut.h"
#include "client/loadtest/latency_histogram.h"
#include "client/loadtest/loadtest_command.h"
#include "client/loadtest/request_trace.h"
#include "common/command_line.h"

namespace lode::app {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

constexpr std::array<int, 3> kThresholdsPx{1, 2, 4};

struct ReplayOptions {
  CommonOptions common;
  double fps = 60;
  std::string order = "best";
  std::string record_file;
  bool no_prefetch = false, json = false;

  stream::StreamOptions streamOptions() const {
    stream::StreamOptions options = common.streamOptions();
    options.engine.prefetch = !no_prefetch;
    options.engine.best_first = order == "best";
    return options;
  }
};

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

uint64_t peakMemoryBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<uint64_t>(usage.ru_maxrss) * 1024;
}

/// Results of all frames of a path.
struct Replayed {
  uint64_t frames = 0;
  /// Number of visible nodes for which nothing is drawn, summed over all frames.
  uint64_t holes = 0;
  uint64_t fallback_frames = 0;  ///< number of frames that draw a fallback in place of a missing part
  LatencyHistogram frame;
  std::optional<double> first_image_ms;
  std::array<double, kThresholdsPx.size()> seconds_above{};
  std::array<std::optional<double>, kThresholdsPx.size()> reached_ms;
  std::optional<double> converged_ms;  ///< time from the start until the last view converged
  stream::StreamStatus status;
};

class Replay {
 public:
  explicit Replay(const ReplayOptions& options) : options_(options), size_(options.common.size()) {}

  Replayed run() {
    OpenedTarget target(options_.common, options_.streamOptions(), !options_.json);
    start_ = target.start();
    const Clock::time_point begin = Clock::now();
    const double from_s = target.path().keys.front().t;
    const double path_s = target.path().keys.back().t - from_s;
    const double patience_s = path_s + options_.common.timeout_s;
    for (double t_s = 0; t_s <= patience_s; t_s = secondsSince(begin)) {
      see(target.streamer(), target.viewAt(from_s + std::min(t_s, path_s), size_));
      if (t_s >= path_s && finished()) break;
      std::this_thread::sleep_until(begin + frameTime(result_.frames));
    }
    return result_;
  }

 private:
  Clock::duration frameTime(uint64_t number) const {
    return std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(static_cast<double>(number) / options_.fps));
  }

  /// Does the work of one frame, except drawing, and records the results.
  void see(stream::Streamer& streamer, const core::View& view) {
    const Clock::time_point frame_start = Clock::now();
    streamer.setView(view, options_.common.pixels);
    result_.status = streamer.status();
    const core::Cut* const cut = result_.status.cut.get();
    const std::vector<uint32_t> shown = cut != nullptr ? shownParts(*cut, view) : std::vector<uint32_t>();
    result_.frame.add(Clock::now() - frame_start);
    ++result_.frames;
    const double now_ms = 1e3 * secondsSince(start_);
    is_current_ = cut != nullptr && cut->view == view;
    if (cut != nullptr && !result_.first_image_ms) result_.first_image_ms = now_ms;
    const float error_px =
        cut != nullptr ? lookAt(*cut, shown, view) : std::numeric_limits<float>::infinity();
    for (size_t i = 0; i < kThresholdsPx.size(); ++i) {
      if (error_px > static_cast<float>(kThresholdsPx[i]))
        result_.seconds_above[i] += 1 / options_.fps;
      else if (!result_.reached_ms[i])
        result_.reached_ms[i] = now_ms;
    }
    if (view != view_) result_.converged_ms.reset();
    view_ = view;
    const bool converged = is_current_ && hasConverged(result_.status);
    if (!converged)
      result_.converged_ms.reset();
    else if (!result_.converged_ms)
      result_.converged_ms = now_ms;
  }

  /// Counts the holes and fallbacks of a frame. @param shown  parts to draw. @return the largest error of
  /// these parts in this view.
  float lookAt(const core::Cut& cut, std::span<const uint32_t> shown, const core::View& view) {
    result_.holes += countHoles(cut, shown, view);
    result_.fallback_frames +=
        std::ranges::any_of(shown, [&](uint32_t number) { return number >= cut.parts.size(); });
    return shownErrorPx(cut, shown, view);
  }

  bool finished() const {
    const stream::StreamStatus& status = result_.status;
    return status.ended || status.exhausted || (is_current_ && (result_.converged_ms || status.settled));
  }

  const ReplayOptions& options_;
  const PictureSize size_;
  Clock::time_point start_;
  Replayed result_;
  core::View view_;          // view of the last frame
  bool is_current_ = false;  // true if the last frame's cut was refined for that frame's view
};

template <typename Value>
Json byThreshold(const std::array<Value, kThresholdsPx.size()>& values, Json (*toJson)(const Value&)) {
  Json json;
  for (size_t i = 0; i < values.size(); ++i) json[std::to_string(kThresholdsPx[i])] = toJson(values[i]);
  return json;
}

Json orNull(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json toJson(const Replayed& replayed) {
  const stream::StreamStatus& status = replayed.status;
  Json json{{"converged", replayed.converged_ms.has_value()},
            {"frames", replayed.frames},
            {"frame_ms",
             {{"p50", replayed.frame.percentileMs(0.5)},
              {"p99", replayed.frame.percentileMs(0.99)},
              {"max", replayed.frame.maxMs()}}},
            {"holes", replayed.holes},
            {"fallback_frames", replayed.fallback_frames},
            {"first_image_ms", orNull(replayed.first_image_ms)},
            {"reached_px_ms", byThreshold(replayed.reached_ms, orNull)},
            {"converged_ms", orNull(replayed.converged_ms)},
            {"seconds_above_px", byThreshold<double>(replayed.seconds_above,
                                                     [](const double& seconds) { return Json(seconds); })},
            {"bytes_received", status.counts.received_bytes},
            {"cache_bytes", status.counts.cache_bytes},
            {"final_cut_bytes", status.cut ? status.cut->blob_bytes : 0},
            {"max_error_px", status.cut ? Json(status.cut->max_error_px) : Json()},
            {"resident_bytes", status.counts.resident_bytes},
            {"prefetch", prefetchReport(status.counts.prefetch)},
            {"peak_rss_bytes", peakMemoryBytes()}};
  reportGaps(json, status);
  reportLimits(json, status.counts);
  return json;
}

/// Records the requests of the path into a file. Opens the output file first, so that a bad name fails before
/// the work begins.
void record(const ReplayOptions& options) {
  const CommonOptions& common = options.common;
  for (const std::string& input : {common.target, common.camera_file, common.token_file})
    refuseToReplace(input, options.record_file);
  AtomicFile file(options.record_file);
  const std::optional<core::CameraPath> path = wantedPath(common);
  const ResolvedTarget target = resolveTarget(parseTarget(common.target, common.textures_folder),
                                              common.streamOptions(), !options.json);
  const PictureSize size = common.size();
  const PathOf path_of = [&](const ModelSummary& model) {
    return path ? *path : makePath(MadePath::kOrbit, model, 0);
  };
  writeRequestTrace(std::move(file),
                    recordTrace(target.served, target.options, path_of, {size.width_px, size.height_px},
                                common.pixels, common.timeout()));
}

void replay(const ReplayOptions& options) {
  if (!options.record_file.empty()) record(options);
  const Replayed replayed = Replay(options).run();
  if (options.json) {
    std::printf("%s\n", toJson(replayed).dump().c_str());
  } else {
    std::printf(
        "%llu frames, %llu holes, first image after %.0f ms, %.1f s above 2 pixels, %llu bytes received\n",
        static_cast<unsigned long long>(replayed.frames), static_cast<unsigned long long>(replayed.holes),
        replayed.first_image_ms.value_or(0), replayed.seconds_above[1],
        static_cast<unsigned long long>(replayed.status.counts.received_bytes));
  }
  if (!replayed.converged_ms) refuseUnconverged("the path's end", replayed.status, options.common);
  warnOfGaps(replayed.status, options.common);
}

}  // namespace

void declareReplay(CLI::App& program, int& /*exit_status*/) {
  CLI::App* command = program.add_subcommand(
      "replay", "Moves along a camera path in real time, without a window: errors over time, bytes, memory");
  const auto options = std::make_shared<ReplayOptions>();
  addCommonOptions(*command, options->common);
  command->add_option("--fps", options->fps, "frames per second")
      ->check(numberFrom(1.0, 1000.0))
      ->capture_default_str();
  command->add_flag("--no-prefetch", options->no_prefetch, "request nothing ahead of the camera");
  command->add_option("--order", options->order, "order of requests: best, or first-come for comparison")
      ->check(CLI::IsMember({"best", "first-come"}))
      ->capture_default_str();
  command
      ->add_option("--record", options->record_file,
                   "write the requests of the path to this file, for loadtest --trace")
      ->type_name("FILE");
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options] { replay(*options); });
}

}  // namespace lode::app
