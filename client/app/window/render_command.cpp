#include "client/app/window/render_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "client/app/cli/common_options.h"
#include "client/app/cli/not_converged.h"
#include "client/app/cli/opened_target.h"
#include "client/app/cli/stream_report.h"
#include "client/app/cli/target.h"
#include "client/app/window/look_options.h"
#include "client/app/window/memory_shares.h"
#include "client/app/window/output/film_folder.h"
#include "client/app/window/output/picture_file.h"
#include "client/app/window/output/video.h"
#include "client/app/window/scene/scene_subject.h"
#include "client/core/view/camera_path.h"
#include "client/render/framebuffer.h"
#include "client/render/image.h"
#include "client/render/offscreen_context.h"
#include "client/render/passes/ambient_occlusion.h"
#include "client/render/renderer.h"
#include "client/stream/streamer.h"
#include "common/command_line.h"
#include "common/error.h"
#include "common/io/interrupted.h"
#include "common/io/output_target.h"

namespace lode::app {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxPictures = 1'000'000;

struct RenderOptions {
  CommonOptions common;
  LookOptions look;
  std::string output;  ///< one picture, of the first key
  std::string folder;  ///< or one for each frame,
  std::string video;   ///< or these as a video
  double fps = 30;
  bool json = false;
};

/// When and where each picture is taken.
struct Shot {
  double t = 0;
  fs::path file;
};

size_t frameCount(const RenderOptions& options, const core::CameraPath& path) {
  const double frames = std::floor((path.keys.back().t - path.keys.front().t) * options.fps + 1e-9) + 1;
  if (frames > static_cast<double>(kMaxPictures)) {
    throw Error(ErrorCode::kUsage,
                "the path has more than " + std::to_string(kMaxPictures) + " frames; choose a lower --fps");
  }
  return static_cast<size_t>(frames);
}

std::vector<Shot> planShots(const RenderOptions& options, const core::CameraPath& path) {
  const double start = path.keys.front().t;
  if (!options.output.empty()) return {{start, options.output}};
  std::vector<Shot> shots;
  for (size_t frame = 0, frames = frameCount(options, path); frame < frames; ++frame) {
    shots.push_back(
        {start + static_cast<double>(frame) / options.fps, fs::path(options.folder) / frameName(frame)});
  }
  return shots;
}

/// Where a video's frames lie until it is made.
class FramesFolder {
 public:
  explicit FramesFolder(fs::path path) : path_(std::move(path)), unfinished_(path_) {}
  ~FramesFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  FramesFolder(const FramesFolder&) = delete;
  FramesFolder& operator=(const FramesFolder&) = delete;

 private:
  const fs::path path_;
  const Unfinished unfinished_;
};

/// What the pictures so far show.
struct Shown {
  struct Unconverged {
    double t = 0;
    stream::StreamStatus status;
  };
  size_t pictures = 0;
  float max_error_px = 0;
  std::vector<render::LegendEntry> legend;  ///< of the last
  std::optional<Unconverged> first_unconverged;
  stream::StreamStatus last;
};

std::string hexOf(const glm::u8vec3& colour) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", colour.r, colour.g, colour.b);
  return text;
}

void printJson(const Shown& shown, std::FILE* report) {
  using Json = nlohmann::ordered_json;
  Json json;
  json["converged"] = !shown.first_unconverged;
  json["pictures"] = shown.pictures;
  json["max_error_px"] = shown.pictures > 0 ? Json(shown.max_error_px) : Json();
  json["tiles_left_out"] = shown.last.counts.tiles_left_out;
  reportGaps(json, shown.first_unconverged ? shown.first_unconverged->status : shown.last);
  for (const render::LegendEntry& entry : shown.legend)
    json["legend"].push_back({{"colour", hexOf(entry.colour)}, {"meaning", entry.meaning}});
  std::fprintf(report, "%s\n", json.dump().c_str());
}

void printLegend(const Shown& shown, std::FILE* report) {
  for (const render::LegendEntry& entry : shown.legend)
    std::fprintf(report, "%s  %s\n", hexOf(entry.colour).c_str(), entry.meaning.c_str());
}

/// A model whose server, stream and renderer live as long.
class ModelSubject : public PictureSubject {
 public:
  ModelSubject(const CommonOptions& options, bool announce)
      : options_(options),
        memory_(render::shareMemory(options.streamOptions().engine.memory_budget_bytes)),
        opened_(options, streamOptions(), announce),
        up_(opened_.up()),
        renderer_(opened_.model().lattice.step, memory_.gpu) {}

  const core::CameraPath& path() const override { return opened_.path(); }

  Taken take(double t, const render::Framebuffer& target, render::DrawStyle style) override {
    const core::View view = opened_.viewAt(t, options_.size());
    opened_.streamer().setView(view, options_.pixels);
    Taken taken;
    taken.status = opened_.streamer().waitForConvergence(options_.timeout());
    const std::shared_ptr<const core::Cut>& cut = taken.status.cut;
    taken.is_finest = cut && cut->converged;
    taken.has_converged = hasConverged(taken.status, options_.pixels);
    if (!taken.is_finest) return taken;
    taken.max_error_px = cut->max_error_px;
    renderer_.show(cut);
    renderer_.uploadInRenderThread({.wait = true});
    if (!renderer_.upToDate()) {
      throw Error(ErrorCode::kLimit, options_.target +
                                         " needs more graphics memory than there is; allow a larger error "
                                         "with --pixels");
    }
    style.up = up_;
    renderer_.draw(view, target, style, {.now_s = t});
    taken.legend = legendOf(style.show, renderer_.inPicture(), options_.pixels);
    return taken;
  }

 private:
  stream::StreamOptions streamOptions() const {
    stream::StreamOptions options = options_.streamOptions();
    options.engine.memory_budget_bytes = memory_.stream_bytes;
    options.engine.refine.drawn_budget_bytes = memory_.drawn_bytes;
    return options;
  }

  const CommonOptions options_;
  const render::MemoryShares memory_;
  OpenedTarget opened_;
  const glm::dvec3 up_;
  render::Renderer renderer_;
};

std::unique_ptr<PictureSubject> open(const RenderOptions& options) {
  if (namesScene(options.common.target)) return std::make_unique<SceneSubject>(options.common, !options.json);
  return std::make_unique<ModelSubject>(options.common, !options.json);
}

/// Said before the work.
void checkOutput(const RenderOptions& options) {
  if (options.output.empty() == options.folder.empty())
    throw Error(ErrorCode::kUsage, "render needs one of -o OUT.png, --frames DIR and --video OUT.mp4");
  if (!options.output.empty()) checkPictureFile(options.common.target, options.output);
  if (options.look.show == nameOf(render::ColorMode::kAges))
    throw Error(ErrorCode::kUsage,
                "--show ages is for view: nothing in a picture of render's has been there for a while");
}

void render(const RenderOptions& options) {
  checkOutput(options);
  std::FILE* const report = options.output.empty() ? stdout : reportStream(options.output, options.json);
  const PictureSize size = options.common.size();
  // What this machine cannot draw is said before a long build is begun.
  const render::OffscreenContext context;
  const render::Framebuffer target(size.width_px, size.height_px);
  render::AmbientOcclusion occlusion;
  if (!options.folder.empty()) {
    makeFilmFolder(options.folder);
    const auto path = wantedPath(options.common);
    refuseOtherFilm(options.folder, path ? frameCount(options, *path) : 1);
  }

  const std::unique_ptr<PictureSubject> subject = open(options);
  Shown shown;
  const render::DrawStyle style = styleOf(options.look);
  for (const Shot& shot : planShots(options, subject->path())) {
    Taken taken = subject->take(shot.t, target, style);
    if (!shown.first_unconverged && !taken.has_converged) shown.first_unconverged = {shot.t, taken.status};
    if (!taken.is_finest) break;
    shown.last = taken.status;
    shown.legend = std::move(taken.legend);
    occlusion.darken(target, glm::radians(subject->path().fov_y_deg), style.show);
    target.resolve();
    render::writePng(shot.file, target.readPixels());
    ++shown.pictures;
    shown.max_error_px = std::max(shown.max_error_px, taken.max_error_px);
  }
  if (options.json)
    printJson(shown, report);
  else
    printLegend(shown, report);
  if (shown.first_unconverged) {
    refuseUnconverged("the picture at t = " + std::to_string(shown.first_unconverged->t),
                      shown.first_unconverged->status, options.common);
  }
  warnOfGaps(shown.last, options.common);
}

void renderVideo(RenderOptions options) {
  refuseToReplace(options.common.target, options.video);
  const char* const search_path = std::getenv("PATH");
  const fs::path ffmpeg = findFfmpeg(search_path != nullptr ? search_path : "");
  options.folder = options.video + ".frames";
  if (fs::exists(options.folder))
    throw Error(ErrorCode::kIo, options.folder + " is in the way of the video's frames: remove it");
  const FramesFolder frames(options.folder);
  render(options);
  makeVideo(ffmpeg, options.folder, options.fps, options.video);
}

}  // namespace

void declareRender(CLI::App& program, int& /*exit_status*/) {
  CLI::App* command = program.add_subcommand(
      "render",
      "Draws pictures of a model or a scene off-screen, each when it has converged; needs no display");
  const auto options = std::make_shared<RenderOptions>();
  addCommonOptions(*command, options->common, Takes::kScenesToo);
  auto* output =
      command->add_option("-o,--output", options->output, "write the picture of the path's first key")
          ->type_name("OUT.png");
  auto* frames =
      command->add_option("--frames", options->folder, "write a picture for every frame of the path")
          ->type_name("DIR")
          ->excludes(output);
  auto* video = command->add_option("--video", options->video, "write the path as a video; needs ffmpeg")
                    ->type_name("OUT.mp4")
                    ->excludes(output)
                    ->excludes(frames);
  command->add_option("--fps", options->fps, "frames a second of --frames and --video")
      ->check(numberFrom(0.001, 1000.0))
      ->excludes(output)
      ->capture_default_str();
  addLookOptions(*command, options->look);
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options, video] {
    if (video->count() > 0)
      renderVideo(*options);
    else
      render(*options);
  });
}

}  // namespace lode::app
