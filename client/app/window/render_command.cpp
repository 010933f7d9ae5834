#include "client/app/window/render_command.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "client/app/cli/common_options.h"
#include "client/app/cli/opened_target.h"
#include "client/app/cli/stream_report.h"
#include "client/app/cli/target.h"
#include "client/app/window/look_options.h"
#include "client/app/window/memory_shares.h"
#include "client/app/window/output/picture_file.h"
#include "client/app/window/output/video.h"
#include "client/app/window/scene/rendered_scene.h"
#include "client/core/view/camera_path.h"
#include "client/render/gl/framebuffer.h"
#include "client/render/gl/image.h"
#include "client/render/gl/offscreen_context.h"
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
  // The user gives exactly one of the next three.
  std::string output;  ///< file for one picture, at the first key of the camera path
  std::string folder;  ///< folder for one picture per frame
  std::string video;   ///< file for a video of the whole path
  double fps = 30;
  bool json = false;
};

/// A picture to draw: its time on the camera's path, and its file.
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

/// Temporary folder for the frames of a video. The destructor removes the folder.
class FramesFolder {
 public:
  /// @throws Error kIo if the path exists already, or if the folder cannot be created.
  explicit FramesFolder(fs::path path) : path_(std::move(path)) {
    const Uninterrupted until_it_is_known;
    if (::mkdir(path_.c_str(), S_IRWXU) != 0)
      throw Error(ErrorCode::kIo, path_.string() + ": the video's frames need a new folder of this name: " +
                                      std::strerror(errno) + "; remove it, or name another output");
    unfinished_ = Unfinished(path_);
  }
  ~FramesFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  FramesFolder(const FramesFolder&) = delete;
  FramesFolder& operator=(const FramesFolder&) = delete;

 private:
  const fs::path path_;
  Unfinished unfinished_;
};

/// Results of the pictures drawn so far.
struct Shown {
  struct Unconverged {
    double t = 0;
    stream::StreamStatus status;
  };
  bool has_preview = false;
  size_t pictures = 0;
  float max_error_px = 0;
  std::vector<render::LegendEntry> legend;  ///< legend of the last picture
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
  json["preview"] = shown.has_preview;
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

/// Rejects invalid outputs before the work begins. @throws Error.
void checkOutput(const RenderOptions& options) {
  if (options.output.empty() == options.folder.empty())
    throw Error(ErrorCode::kUsage, "render needs one of -o OUT.png, --frames DIR and --video OUT.mp4");
  if (!options.output.empty()) checkPictureFile(options.common.target, options.output);
  if (traitsOf(styleOf(options.look).show).shows_time)
    throw Error(ErrorCode::kUsage, "--show " + options.look.show +
                                       " works only with view: in a rendered picture, every part is new");
}

void render(const RenderOptions& options) {
  checkOutput(options);
  std::FILE* const report = options.output.empty() ? stdout : reportStream(options.output, options.json);
  const PictureSize size = options.common.size();
  // Create the context first, so that a machine without OpenGL fails before a long build begins.
  const render::OffscreenContext context;
  const render::Framebuffer target(size.width_px, size.height_px);
  render::AmbientOcclusion occlusion;
  if (!options.folder.empty()) {
    makeFilmFolder(options.folder);
    const auto path = wantedPath(options.common);
    refuseOtherFilm(options.folder, path ? frameCount(options, *path) : 1);
  }

  RenderedScene scene(options.common, !options.json);
  Shown shown;
  const render::DrawStyle style = styleOf(options.look);
  for (const Shot& shot : planShots(options, scene.path())) {
    RenderedScene::Picture picture = scene.draw(shot.t, target, style);
    if (!shown.first_unconverged && !picture.has_converged)
      shown.first_unconverged = {shot.t, picture.status};
    if (!picture.is_drawn) break;
    shown.last = picture.status;
    shown.has_preview = shown.has_preview || picture.has_preview;
    shown.legend = std::move(picture.legend);
    occlusion.darken(target, glm::radians(scene.path().fov_y_deg), style.show);
    target.resolve();
    render::writePng(shot.file, target.readPixels(),
                     options.output.empty() ? OutputName::kDerived : OutputName::kTyped);
    ++shown.pictures;
    shown.max_error_px = std::max(shown.max_error_px, picture.max_error_px);
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
  const OutputTarget video = findOutput(options.video);
  if (video.is_stream)
    throw Error(ErrorCode::kUsage, options.video + ": is a pipe or a device: name a file for the video");
  options.folder = video.path.string() + ".frames";
  const FramesFolder frames(options.folder);
  render(options);
  makeVideo(ffmpeg, options.folder, options.fps, video.path);
}

}  // namespace

void declareRender(CLI::App& program, int& /*exit_status*/) {
  CLI::App* command = program.add_subcommand(
      "render",
      "Draws pictures of a model or a scene off-screen, each when it has converged; needs no display");
  const auto options = std::make_shared<RenderOptions>();
  addCommonOptions(*command, options->common, Takes::kScenesToo);
  addPreviewOption(*command, options->common);
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
  command->add_option("--fps", options->fps, "frames per second of --frames and --video")
      ->check(numberFrom(0.001, 1000.0))
      ->excludes(output)
      ->capture_default_str();
  addLookOptions(*command, options->look);
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options, video] {
    takeStandardInput(options->common);
    if (video->count() > 0)
      renderVideo(*options);
    else
      render(*options);
  });
}

}  // namespace lode::app
