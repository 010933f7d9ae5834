#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "client/app/cli/common_options.h"
#include "client/app/cli/cut_export.h"
#include "client/app/cli/opened_target.h"
#include "client/app/cli/remedy_words.h"
#include "client/app/cli/stream_report.h"
#include "common/error.h"
#include "common/io/mesh_file.h"
#include "common/io/output_target.h"

namespace lode::app {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

struct FetchOptions {
  CommonOptions common;
  std::string output;
  bool json = false;
};

double msSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Result of streaming what the camera sees at one key of its path.
struct KeyResult {
  double t = 0;
  // Times in ms since the view was set; for the first key, since the connection started.
  std::optional<double> first_image_ms, converged_ms;
  uint64_t converged_bytes = 0;  ///< bytes received by the time the key converged
  bool is_complete = false;      ///< the cut has converged and the stream has settled
  /// True if the cut is complete and the eye is so near that one step of the model's position lattice exceeds
  /// the error threshold.
  bool is_lattice_seen = false;
  stream::StreamStatus status;

  bool converged() const { return converged_ms.has_value(); }
  bool lacksOnlyTiles() const { return is_complete && status.cut->lost_tiles > 0; }
};

Json toJson(const KeyResult& key) {
  Json json;
  json["t"] = key.t;
  json["converged"] = key.converged();
  json["finest"] = key.is_lattice_seen;
  json["first_image_ms"] = key.first_image_ms ? Json(*key.first_image_ms) : Json();
  json["converged_ms"] = key.converged_ms ? Json(*key.converged_ms) : Json();
  json["converged_bytes"] = key.converged() ? Json(key.converged_bytes) : Json();
  json["bytes_received"] = key.status.counts.received_bytes;
  json["cache_bytes"] = key.status.counts.cache_bytes;
  json["texture_bytes"] = key.status.counts.texture_blob_bytes;
  json["tiles"] = key.status.counts.tiles;
  json["tiles_left_out"] = key.status.counts.tiles_left_out;
  reportGaps(json, key.status);
  json["final_cut_bytes"] = key.status.cut ? key.status.cut->blob_bytes : 0;
  json["triangles"] = key.status.cut ? key.status.cut->triangles : 0;
  json["nodes"] = key.status.cut ? key.status.cut->parts.size() : 0;
  json["max_error_px"] = key.status.cut ? Json(key.status.cut->max_error_px) : Json();
  return json;
}

/// Returns the results of the last key, the times of the whole run, and the results of each key.
Json toJson(const std::vector<KeyResult>& keys, double total_ms) {
  Json json = toJson(keys.back());
  json.erase("t");
  const bool converged =
      std::all_of(keys.begin(), keys.end(), [](const KeyResult& key) { return key.converged(); });
  json["converged"] = converged;
  json["first_image_ms"] = toJson(keys.front())["first_image_ms"];
  json["converged_ms"] = converged ? Json(total_ms) : Json();
  reportLimits(json, keys.back().status.counts);
  for (const KeyResult& key : keys) json["keys"].push_back(toJson(key));
  return json;
}

class Fetch {
 public:
  explicit Fetch(const FetchOptions& options) : options_(options), size_(options.common.size()) {}

  void run() {
    OpenedTarget target(options_.common, options_.common.streamOptions(), !options_.json);
    start_ = target.start();
    is_preview_ = target.isPreview();
    double total_ms = 0;  // time until the last key converged
    for (const core::CameraKey& camera : target.path().keys) {
      // The first key is timed from the start of the connection.
      const double begin_ms = keys_.empty() ? 0 : msSince(start_);
      keys_.push_back(converge(target, camera.t));
      total_ms = keys_.back().converged() ? begin_ms + *keys_.back().converged_ms : msSince(start_);
      is_preview_ = is_preview_ || showsPreview(keys_.back().status, target.model());
      if (!keys_.back().converged() && !keys_.back().lacksOnlyTiles()) break;
    }
    const KeyResult& last = keys_.back();
    std::string left_out;
    if (last.is_complete && !options_.output.empty()) left_out = write(last.status, target.model());
    if (options_.json) printJson(total_ms);
    refuseFailed(left_out);
    if (!left_out.empty()) std::fprintf(stderr, "lodestream: %s\n", left_out.c_str());
    if (!options_.json) print(total_ms);
    warnOfGaps(last.status, options_.common);
  }

 private:
  std::chrono::milliseconds left() const {
    const auto spent = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - start_);
    return std::max(options_.common.timeout() - spent, std::chrono::milliseconds(0));
  }

  KeyResult converge(OpenedTarget& target, double t) {
    const Clock::time_point start = keys_.empty() ? start_ : Clock::now();
    stream::Streamer& streamer = target.streamer();
    KeyResult key;
    key.t = t;
    streamer.setView(target.viewAt(t, size_), options_.common.pixels);
    if (const stream::StreamStatus first = streamer.waitForCut(left()); first.current && first.cut)
      key.first_image_ms = msSince(start);
    const stream::StreamStatus seen = streamer.waitForConvergence(left());
    if (hasConverged(seen)) {
      key.converged_ms = msSince(start);
      key.converged_bytes = seen.counts.received_bytes;
    }
    key.status = streamer.waitUntilSettled(left());
    key.is_complete = key.status.settled && key.status.cut && key.status.cut->converged;
    key.is_lattice_seen = key.is_complete && key.status.cut->max_error_px > options_.common.pixels;
    return key;
  }

  /// Throws an Error if a key has failed. @param left_out  text to append to the error's message; may be
  /// empty.
  void refuseFailed(const std::string& left_out) const {
    try {
      for (const KeyResult& key : keys_)
        if (!key.converged() || (!key.is_complete && !options_.output.empty()))
          refuseUnconverged("key " + std::to_string(&key - keys_.data()), key.status, options_.common);
    } catch (const Error& failed) {
      if (left_out.empty()) throw;
      throw Error(failed.code(), messageOf(failed) + "; " + left_out);
    }
  }

  /// Writes the cut to the output. @return a message that names the images left out; empty if none is left
  /// out.
  std::string write(const stream::StreamStatus& status, const ModelSummary& model) {
    const core::Cut& cut = *status.cut;
    const Mesh mesh = weldCut(cut, model.attributes);
    const CutImages images = writeCutImages(cut, mesh, options_.output);
    files_beside_ = writeMesh(options_.output, mesh, model.lattice, images.files);
    const char* const why = status.counts.tiles_left_out == 0
                                ? "it is unavailable"
                                : "the memory budget had no room for it; raise --memory-budget";
    if (images.left_out.empty()) return {};
    std::string names = images.left_out.front();
    for (const std::string& name : std::span(images.left_out).subspan(1)) names += ", " + name;
    return options_.output + " is written, but " +
           (images.left_out.size() == 1 ? "the image " : "the images ") + names +
           (images.left_out.size() == 1 ? " is" : " are") + " left out, because " + why;
  }

  void printJson(double total_ms) const {
    Json json = toJson(keys_, total_ms);
    json["preview"] = is_preview_;
    json["files_beside"] = Json::array();
    for (const std::filesystem::path& file : files_beside_) json["files_beside"].push_back(file.string());
    std::printf("%s\n", json.dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
  }

  void print(double total_ms) const {
    std::fputs(describeFilesBeside(files_beside_).c_str(), report_);
    const KeyResult& last = keys_.back();
    if (is_preview_)
      std::fprintf(report_, "only a preview, at most %.2f px off where it is seen: ",
                   static_cast<double>(last.status.cut->max_error_px));
    std::fprintf(
        report_,
        "%s in %.0f ms, first image after %.0f ms: %llu triangles in %zu nodes, %llu bytes received\n",
        is_preview_ ? "complete" : "converged", total_ms, keys_.front().first_image_ms.value_or(total_ms),
        static_cast<unsigned long long>(last.status.cut->triangles), last.status.cut->parts.size(),
        static_cast<unsigned long long>(last.status.counts.received_bytes));
  }

  const FetchOptions& options_;
  const PictureSize size_;
  std::FILE* const report_ = reportStream(options_.output, options_.json);
  Clock::time_point start_ = Clock::now();
  bool is_preview_ = false;
  std::vector<KeyResult> keys_;
  std::vector<std::filesystem::path> files_beside_;  ///< files written beside the output, such as images
};

void fetch(const FetchOptions& options) {
  meshFormatOf(options.output);  // reject an invalid output before the work begins
  if (!options.output.empty()) findOutput(options.output);
  refuseToReplace(options.common.target, options.output);
  Fetch run(options);
  run.run();
}

}  // namespace

void declareFetch(CLI::App& program, int& /*exit_status*/) {
  CLI::App* command = program.add_subcommand(
      "fetch", "Streams what a camera sees until it has converged, without a window: times, bytes, the cut");
  const auto options = std::make_shared<FetchOptions>();
  addCommonOptions(*command, options->common);
  addPreviewOption(*command, options->common);
  command
      ->add_option("-o,--output", options->output,
                   "write the cut of the last key, and beside it its images, as sharp as the camera needs; "
                   "the ending selects the format")
      ->check([](const std::string& name) { return name.empty() ? "its name is empty: name a file" : ""; })
      ->type_name("CUT.ply|.obj|.glb");
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options] {
    takeStandardInput(options->common);
    fetch(*options);
  });
}

}  // namespace lode::app
