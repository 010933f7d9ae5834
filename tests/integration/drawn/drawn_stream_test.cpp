// Runs a server and the threads of a window in one process: a stream refines, receives and decodes while a
// renderer draws its cuts. The thread sanitizer runs these tests.

#include <filesystem>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "client/app/window/memory_shares.h"
#include "client/render/gl/framebuffer.h"
#include "client/render/gl/offscreen_context.h"
#include "client/render/renderer.h"
#include "common/error.h"
#include "tests/integration/streaming/streaming_fixture.h"
#include "tests/support/background_watch.h"

namespace lode::test {
namespace {

namespace fs = std::filesystem;
using stream::Streamer;
using stream::StreamStatus;

/// Fixture that skips its tests if no OpenGL 4.5 context can be created.
class DrawnStreaming : public Streaming {
 protected:
  void SetUp() override {
    try {
      context_ = std::make_unique<render::OffscreenContext>();
    } catch (const Error& error) {
      GTEST_SKIP() << "no OpenGL here: " << error.what();
    }
  }

  static render::Image pictureOf(render::Renderer& renderer, const core::View& view) {
    const render::Framebuffer target(view.width_px, view.height_px, 1);
    renderer.draw(view, target);
    target.resolve();
    return target.readPixels();
  }

  std::unique_ptr<render::OffscreenContext> context_;
};

TEST_F(DrawnStreaming, drawsWholeCutsAndEndsInThePictureOfAFreshStream) {
  constexpr int kFrames = 60;
  Streamer streamer(served_, threads(2));
  const ModelSummary& model = streamer.waitForModel(kPatience);
  render::ResidencyOptions tight;
  tight.spare_bytes = 0;  // evicts meshes as soon as the cut no longer has them
  render::Renderer renderer(model.lattice.step, tight);
  const render::Framebuffer target(640, 480, 1);
  streamer.setView(viewAt(0, model), 0.5f);
  ASSERT_TRUE(streamer.waitForCut(kPatience).cut);
  for (int frame = 0; frame < kFrames; ++frame) {
    const core::View view = viewAt(frame / 4, model);
    streamer.setView(view, 0.5f);
    renderer.show(streamer.status().cut);
    renderer.uploadInRenderThread({.bytes = 64u << 10});
    renderer.draw(view, target);
    EXPECT_TRUE(renderer.meshes().drawnCut() || frame < kFrames / 2);
  }
  const core::View last = viewAt(kFrames / 4, model);
  streamer.setView(last, 0.5f);
  renderer.show(streamer.waitUntilSettled(kPatience).cut);
  // Upload twice, because the upload of an earlier cut may be in progress.
  for (int cuts = 0; cuts < 2; ++cuts) renderer.uploadInRenderThread({.wait = true});
  ASSERT_TRUE(renderer.upToDate());

  Streamer fresh(served_, threads(1));
  fresh.waitForModel(kPatience);
  fresh.setView(last, 0.5f);
  render::Renderer other(model.lattice.step);
  other.show(fresh.waitUntilSettled(kPatience).cut);
  other.uploadInRenderThread({.wait = true});
  EXPECT_TRUE(pictureOf(renderer, last).rgba == pictureOf(other, last).rgba);
}

/// A closed model of 60,000 triangles. The server serves two builds of the model by turns.
class DrawnFading : public DrawnStreaming {
 protected:
  DrawnFading() {
    stopServer();
    serveBuild(0);
    startServer();
  }
  void serveBuild(int number) {
    const fs::path models = fs::path(LODE_BIN_DIR) / "test-models";
    fs::copy_file(models / (number % 2 == 0 ? "painted.lode" : "painted_in_small_nodes.lode"),
                  folder_ / "next.lode");
    fs::rename(folder_ / "next.lode", folder_ / "a.lode");
  }
  /// Returns a random camera around the model that looks at a point of it.
  static core::View randomView(const ModelSummary& model, std::mt19937& random) {
    std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi), height(-0.9, 0.9), near(0.45, 1);
    core::CameraPath path = core::framingCamera(model);
    core::CameraKey& key = path.keys.front();
    const double away = glm::length(key.eye - key.target) * near(random), at = angle(random);
    const double z = height(random), side = angle(random);
    key.eye =
        key.target + away * glm::dvec3(std::sqrt(1 - z * z) * glm::dvec2(std::cos(at), std::sin(at)), z);
    key.target += 0.1 * away * glm::dvec3(std::cos(side), std::sin(side), 0);
    key.up = {0, 0, 1};
    return core::toView(key, path.fov_y_deg, 200, 150, model);
  }
};

TEST_F(DrawnFading, neverShowsTheBackgroundInsideAModelThatSharpensOrIsReplaced) {
  constexpr int kCameras = 30;
  constexpr double kFrameS = 0.07;
  std::mt19937 random(3);
  Streamer streamer(served_, threads(1));
  const ModelSummary model = streamer.waitForModel(kPatience);
  BackgroundWatch watch(model.lattice.step, 200, 150);
  double now_s = 0;
  uint64_t build = 0;
  int builds = 0;
  for (int camera = 0; camera < kCameras; ++camera) {
    if (camera % 5 == 4) {
      serveBuild(camera / 5 + 1);
      server_->reload();
    }
    const core::View view = randomView(model, random);
    for (const float threshold_px : {3.0f, 0.7f}) {
      streamer.setView(view, threshold_px);
      watch.frame(streamer.waitForCut(kPatience).cut, view, now_s += kFrameS);
      const StreamStatus status = streamer.waitUntilSettled(kPatience);
      builds += std::exchange(build, status.cut_build) != status.cut_build;
      for (int frame = 0; frame < 3; ++frame) watch.frame(status.cut, view, now_s += kFrameS);
    }
  }
  EXPECT_EQ(watch.counts().background, 0u);
  EXPECT_GT(watch.counts().fading_frames, 60u);
  EXPECT_GT(watch.counts().inside, 500'000u);
  EXPECT_GT(builds, 3);
}

TEST_F(DrawnFading, neverShowsTheBackgroundInsideAModelWhoseRegionsArriveOneByOne) {
  constexpr unsigned kCameras = 30;
  std::mt19937 random(4);
  Streamer streamer(served_, threads(1));
  const ModelSummary model = streamer.waitForModel(kPatience);
  BackgroundWatch watch(model.lattice.step, 200, 150, 16u << 10);
  double now_s = 0;
  for (unsigned camera = 0; camera < kCameras; ++camera) {
    const core::View view = randomView(model, random);
    for (const float threshold_px : {3.0f, 0.7f}) {
      streamer.setView(view, threshold_px);
      const StreamStatus status = streamer.waitUntilSettled(kPatience);
      do watch.frame(status.cut, view, now_s += 0.05);
      while (!watch.uploaded());
    }
  }
  EXPECT_EQ(watch.counts().background, 0u);
  EXPECT_GT(watch.counts().mixed_frames, kCameras) << "one a camera, in the mean";
  EXPECT_GT(watch.counts().inside, 500'000u);
}

/// The cut of each threshold arrives while parts of the previous cut are still missing.
TEST_F(DrawnFading, neverShowsTheBackgroundInsideAModelWhileNewerCutsArrive) {
  constexpr unsigned kCameras = 12;
  std::mt19937 random(5);
  Streamer streamer(served_, threads(1));
  const ModelSummary model = streamer.waitForModel(kPatience);
  BackgroundWatch watch(model.lattice.step, 200, 150, 4u << 10);
  double now_s = 0;
  unsigned overtaken = 0;
  for (unsigned camera = 0; camera < kCameras; ++camera) {
    const core::View view = randomView(model, random);
    for (const float threshold_px : {3.0f, 2.0f, 0.7f, 1.4f, 0.7f}) {
      streamer.setView(view, threshold_px);
      const StreamStatus status = streamer.waitUntilSettled(kPatience);
      watch.frame(status.cut, view, now_s += 0.05);
      overtaken += !watch.uploaded();
    }
    const StreamStatus status = streamer.status();
    while (!watch.uploaded()) watch.frame(status.cut, view, now_s += 0.05);
  }
  EXPECT_EQ(watch.counts().background, 0u);
  EXPECT_GT(overtaken, kCameras);
  EXPECT_GT(watch.counts().inside, 500'000u);
}

/// A larger model, which takes about 40 MB if it is drawn completely. The parameter is the number of
/// triangles per leaf.
class DrawnWithinMemory : public DrawnStreaming, public testing::WithParamInterface<uint32_t> {
 protected:
  DrawnWithinMemory() {
    stopServer();
    SyntheticModel model =
        makeModel(makeSphere(700, 500, {.attributes = {AttributeSet::kColour}, .extent = 60'000}),
                  {.leaf_triangles = GetParam(), .lods = 4, .extent_bits = 16});
    writeStore(folder_ / "a.lode", model);
    startServer();
  }
};

INSTANTIATE_TEST_SUITE_P(Leaves, DrawnWithinMemory, testing::Values(4000u, 16'384u));

TEST_P(DrawnWithinMemory, countsTheCopiesOnTheGpuInTheMemoryThatAllDrawFrom) {
  constexpr uint64_t kMemoryBytes = 32u << 20;
  const app::MemoryShares memory = app::shareMemory(kMemoryBytes);
  stream::StreamOptions options = threads(1);
  options.engine.memory_budget_bytes = memory.stream_bytes;
  options.engine.refine.drawn_budget_bytes = memory.drawn_bytes;
  Streamer streamer(served_, options);
  const ModelSummary& model = streamer.waitForModel(kPatience);
  render::Renderer renderer(model.lattice.step, memory.gpu);
  uint64_t most_bytes = 0, most_gpu_bytes = 0;
  for (int step = 0; step < 12; ++step) {
    streamer.setView(viewAt(step, model), 0.01f);
    StreamStatus status;
    while (!(status.current && status.settled)) {
      status = streamer.waitForNews(kPatience);
      ASSERT_EQ(status.failure, "");
      renderer.show(status.cut);
      renderer.uploadInRenderThread({.wait = true});
      EXPECT_FALSE(renderer.meshes().overBudget()) << "the GPU has no room for a cut that is shown";
      const core::EngineCounts& counts = status.counts;
      most_gpu_bytes = std::max(most_gpu_bytes, renderer.gpuBytes());
      most_bytes =
          std::max(most_bytes, counts.resident_bytes + counts.texture_bytes + counts.hierarchy_bytes +
                                   counts.transit_bytes + renderer.gpuBytes());
    }
    EXPECT_TRUE(status.limited);
    EXPECT_TRUE(renderer.upToDate()) << "the GPU has no room for the cut that the core's memory allows";
  }
  EXPECT_LE(most_bytes, kMemoryBytes);
  EXPECT_GT(most_gpu_bytes, kMemoryBytes / 5);
}

}  // namespace
}  // namespace lode::test
