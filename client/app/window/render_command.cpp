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
#include "client/app/window/look_options.h"
#include "client/app/window/video.h"
#include "client/core/camera_path.h"
#include "client/render/framebuffer.h"
#include "client/render/image.h"
#include "client/render/memory_shares.h"
#include "client/render/offscreen_context.h"
#include "client/render/renderer.h"
#include "client/stream/streamer.h"
#include "common/error.h"

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

std::vector<Shot> planShots(const RenderOptions& options, const core::CameraPath& path) {
  if (!options.output.empty()) return {{path.keys.front().t, options.output}};
  const double start = path.keys.front().t;
  const double frames = std::floor((path.keys.back().t - start) * options.fps + 1e-9) + 1;
  if (frames > static_cast<double>(kMaxPictures)) {
    throw Error(ErrorCode::kUsage,
                "the path has more than " + std::to_string(kMaxPictures) + " frames; choose a lower --fps");
  }
  std::vector<Shot> shots;
  for (size_t frame = 0; frame < static_cast<size_t>(frames); ++frame) {
    char name[32];
    std::snprintf(name, sizeof name, "frame_%06zu.png", frame);
    shots.push_back({start + static_cast<double>(frame) / options.fps, fs::path(options.folder) / name});
  }
  return shots;
}

/// Where a video's frames lie until it is made.
class FramesFolder {
 public:
  explicit FramesFolder(fs::path path) : path_(std::move(path)) {}
  ~FramesFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  FramesFolder(const FramesFolder&) = delete;
  FramesFolder& operator=(const FramesFolder&) = delete;

 private:
  const fs::path path_;
};

void makeFolder(const std::string& folder) {
  if (folder.empty()) return;
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) {
    throw Error(ErrorCode::kIo,
                folder + " cannot be made: " + failed.message() + "; choose another folder for --frames");
  }
}

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
};

std::string hexOf(const glm::u8vec3& colour) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", colour.r, colour.g, colour.b);
  return text;
}

void printJson(const Shown& shown) {
  using Json = nlohmann::ordered_json;
  Json json;
  json["converged"] = !shown.first_unconverged;
  json["pictures"] = shown.pictures;
  json["max_error_px"] = shown.pictures > 0 ? Json(shown.max_error_px) : Json();
  for (const render::LegendEntry& entry : shown.legend)
    json["legend"].push_back({{"colour", hexOf(entry.colour)}, {"meaning", entry.meaning}});
  std::printf("%s\n", json.dump().c_str());
}

void printLegend(const Shown& shown) {
  for (const render::LegendEntry& entry : shown.legend)
    std::printf("%s  %s\n", hexOf(entry.colour).c_str(), entry.meaning.c_str());
}

void render(const RenderOptions& options) {
  if (options.output.empty() == options.folder.empty()) {
    throw Error(ErrorCode::kUsage, "render needs one of -o OUT.png, --frames DIR and --video OUT.mp4");
  }
  const PictureSize size = options.common.size();
  stream::StreamOptions stream_options = options.common.streamOptions();
  const render::MemoryShares memory = render::shareMemory(stream_options.memory_budget_bytes);
  stream_options.memory_budget_bytes = memory.stream_bytes;
  stream_options.drawn_budget_bytes = memory.drawn_bytes;
  // What this machine cannot draw is said before a long build is begun.
  const render::OffscreenContext context;
  const render::Framebuffer target(size.width_px, size.height_px);
  makeFolder(options.folder);

  OpenedTarget opened(options.common, stream_options, !options.json);
  stream::Streamer& streamer = opened.streamer();
  render::Renderer renderer(opened.model().lattice.step, memory.gpu);
  Shown shown;
  for (const Shot& shot : planShots(options, opened.path())) {
    const core::View view = opened.viewAt(shot.t, size);
    streamer.setView(view, options.common.pixels);
    const stream::StreamStatus status = streamer.waitForConvergence(options.common.timeout());
    const bool is_finest = status.cut && status.cut->converged;
    if (!shown.first_unconverged && (!is_finest || status.cut->max_error_px > options.common.pixels))
      shown.first_unconverged = {shot.t, status};
    if (!is_finest) break;
    renderer.show(status.cut);
    renderer.uploadInRenderThread({.wait = true});
    if (!renderer.upToDate()) {
      throw Error(ErrorCode::kLimit, options.common.target +
                                         " needs more graphics memory than there is; allow a larger error "
                                         "with --pixels");
    }
    render::DrawStyle style = styleOf(options.look);
    style.up = core::cameraAt(opened.path(), shot.t).up;
    renderer.draw(view, target, style, {.now_s = shot.t});
    shown.legend = legendOf(style.show, renderer.inPicture(), options.common.pixels);
    target.resolve();
    render::writePng(shot.file, target.readPixels());
    ++shown.pictures;
    shown.max_error_px = std::max(shown.max_error_px, status.cut->max_error_px);
  }
  if (options.json)
    printJson(shown);
  else
    printLegend(shown);
  if (shown.first_unconverged) {
    refuseUnconverged("the picture at t = " + std::to_string(shown.first_unconverged->t),
                      shown.first_unconverged->status, options.common);
  }
}

void renderVideo(RenderOptions options) {
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
      "render", "Draws pictures of a model off-screen, each when it has converged; needs no display");
  const auto options = std::make_shared<RenderOptions>();
  addCommonOptions(*command, options->common);
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
      ->check(CLI::Range(0.001, 1000.0))
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
