// Counts background inside a closed model: bench_background STORE.lode OTHER_BUILD.lode [CAMERAS] Uses random
// cameras and a server in this process. Compares one-pixel cuts without fades with full resolution. Then
// checks every frame of a stream that cross-fades while cameras change, cuts sharpen and the two builds
// replace each other.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <random>
#include <thread>

#include "client/core/view/camera_path.h"
#include "client/core/view/framing.h"
#include "client/render/gl/offscreen_context.h"
#include "client/stream/streamer.h"
#include "common/error.h"
#include "server/serve/server.h"
#include "tests/bench/print_row.h"
#include "tests/support/background_watch.h"
#include "tests/support/work_folder.h"

namespace lode::bench {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kWidthPx = 640, kHeightPx = 360;
constexpr auto kPatience = std::chrono::seconds(60);
constexpr double kFrameS = 1 / 60.0;
constexpr int kBuildsTakeTurnsAfter = 10;      // number of cameras
constexpr uint32_t kUploadBytes = 256u << 10;  // per frame

class Models {
 public:
  Models(fs::path first, fs::path second) : builds_{std::move(first), std::move(second)} {
    put(0);
    serve::ServeOptions options;
    options.stores = {folder_ / "model.lode"};
    options.listen = "127.0.0.1:0";
    server_.emplace(options);
    thread_ = std::thread([this] { server_->run(); });
  }
  ~Models() {
    server_->stop();
    thread_.join();
  }
  Models(const Models&) = delete;
  Models& operator=(const Models&) = delete;

  stream::ServedModel served() const { return {{"127.0.0.1", server_->port()}, "model"}; }
  void replace(int number) {
    put(number);
    server_->reload();
  }

 private:
  void put(int number) {
    fs::copy_file(builds_[number % 2], folder_ / "next.lode");
    fs::rename(folder_ / "next.lode", folder_ / "model.lode");
  }

  const fs::path builds_[2];
  const test::WorkFolder folder_;
  std::optional<serve::Server> server_;
  std::thread thread_;
};

core::View randomView(const ModelSummary& model, std::mt19937& random) {
  std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi), height(-0.9, 0.9), near(0.4, 1);
  core::CameraPath path = core::framingCamera(model);
  core::CameraKey& key = path.keys.front();
  const double away = glm::length(key.eye - key.target) * near(random), at = angle(random);
  const double z = height(random), side = angle(random);
  key.eye = key.target + away * glm::dvec3(std::sqrt(1 - z * z) * glm::dvec2(std::cos(at), std::sin(at)), z);
  key.target += 0.1 * away * glm::dvec3(std::cos(side), std::sin(side), 0);
  key.up = {0, 0, 1};
  return core::toView(key, path.fov_y_deg, kWidthPx, kHeightPx, model);
}

void print(const char* what, const test::BackgroundWatch::Counter& counts) {
  printRow({{"what", what},
            {"pictures", counts.frames},
            {"fading", counts.fading_frames},
            {"mixed", counts.mixed_frames},
            {"pixels_inside", counts.inside},
            {"background", counts.background}});
}

/// Counts background pixels of one-pixel pictures within the outline of full resolution.
void countSettled(stream::Streamer& streamer, const ModelSummary& model, int cameras) {
  test::BackgroundWatch watch(model.lattice.step, kWidthPx, kHeightPx);
  std::mt19937 random(1);
  test::BackgroundWatch::Counter counts;
  for (int camera = 0; camera < cameras; ++camera) {
    const core::View view = randomView(model, random);
    std::vector<std::vector<bool>> covered;
    for (const float threshold_px : {0.01f, 1.0f}) {
      streamer.setView(view, threshold_px);
      covered.push_back(watch.coveredBy(streamer.waitUntilSettled(kPatience).cut, view));
    }
    ++counts.frames;
    for (uint32_t y = 2; y + 2 < kHeightPx; ++y) {
      for (uint32_t x = 2; x + 2 < kWidthPx; ++x) {
        bool inside = true;
        for (uint32_t row = y - 2; row <= y + 2; ++row)
          for (uint32_t column = x - 2; column <= x + 2; ++column)
            inside = inside && covered[0][size_t{row} * kWidthPx + column];
        if (!inside) continue;
        ++counts.inside;
        if (!covered[1][size_t{y} * kWidthPx + x]) ++counts.background;
      }
    }
  }
  print("cuts of one pixel without fades", counts);
}

/// Counts background pixels in every frame of a stream whose cameras jump and refine from four pixels to one.
void countFading(Models& models, stream::Streamer& streamer, const ModelSummary& model, int cameras) {
  test::BackgroundWatch watch(model.lattice.step, kWidthPx, kHeightPx, kUploadBytes);
  std::mt19937 random(2);
  double now_s = 0;
  uint64_t build = 0;
  int builds = 0;
  for (int camera = 0; camera < cameras; ++camera) {
    if (camera % kBuildsTakeTurnsAfter == kBuildsTakeTurnsAfter - 1)
      models.replace(camera / kBuildsTakeTurnsAfter + 1);
    const core::View view = randomView(model, random);
    for (const float threshold_px : {4.0f, 2.0f, 1.0f}) {
      streamer.setView(view, threshold_px);
      stream::StreamStatus status = streamer.waitForCut(kPatience);
      do {
        status = streamer.waitForNews(std::chrono::milliseconds(10));
        if (std::exchange(build, status.cut_build) != status.cut_build) ++builds;
        watch.frame(status.cut, view, now_s += kFrameS);
      } while (!(status.current && status.settled) || watch.fading() || !watch.uploaded());
    }
  }
  print("frames of a stream", watch.counts());
  printRow({{"what", "builds shown in turn"}, {"count", builds}});
}

void run(int argc, char** argv) {
  if (argc < 3)
    throw Error(ErrorCode::kUsage, "usage: bench_background STORE.lode OTHER_BUILD.lode [CAMERAS]");
  const int cameras = argc > 3 ? std::atoi(argv[3]) : 100;
  const render::OffscreenContext context;
  Models models(argv[1], argv[2]);
  stream::Streamer streamer(models.served(), {});
  const ModelSummary model = streamer.waitForModel(kPatience);
  countSettled(streamer, model, cameras);
  countFading(models, streamer, model, cameras);
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  try {
    lode::bench::run(argc, argv);
    return 0;
  } catch (const lode::Error& failed) {
    std::fprintf(stderr, "%s\n", failed.what());
    return 1;
  }
}
