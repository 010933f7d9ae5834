// The threads of a window in one process with a server: a stream that refines, receives and decodes, and a
// renderer that draws its cuts meanwhile. The thread sanitizer sees them all.

#include <memory>

#include <gtest/gtest.h>

#include "client/render/framebuffer.h"
#include "client/render/memory_shares.h"
#include "client/render/offscreen_context.h"
#include "client/render/renderer.h"
#include "common/error.h"
#include "tests/integration/streaming/streaming_fixture.h"

namespace lode::test {
namespace {

using stream::Streamer;
using stream::StreamStatus;

/// Skipped where no OpenGL 4.5 context can be made.
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

TEST_F(DrawnStreaming, drawsWholeCutsWhileTheCameraMovesAndEndsInThePictureOfAStreamThatBeganThere) {
  constexpr int kFrames = 60;
  Streamer streamer(served_, threads(2));
  const ModelSummary& model = streamer.waitForModel(kPatience);
  render::ResidencyOptions tight;
  tight.spare_bytes = 0;  // what a cut no longer has goes at once
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
  for (int cuts = 0; cuts < 2; ++cuts) renderer.uploadInRenderThread({.wait = true});  // one may be under way
  ASSERT_TRUE(renderer.upToDate());

  Streamer fresh(served_, threads(1));
  fresh.waitForModel(kPatience);
  fresh.setView(last, 0.5f);
  render::Renderer other(model.lattice.step);
  other.show(fresh.waitUntilSettled(kPatience).cut);
  other.uploadInRenderThread({.wait = true});
  EXPECT_TRUE(pictureOf(renderer, last).rgba == pictureOf(other, last).rgba);
}

/// A larger model, of about 40 MB when all of it is drawn.
class DrawnWithinMemory : public DrawnStreaming {
 protected:
  DrawnWithinMemory() {
    stopServer();
    SyntheticModel model =
        makeModel(makeSphere(700, 500, {.attributes = {AttributeSet::kColour}, .extent = 60'000}),
                  {.leaf_triangles = 4000, .extent_bits = 16});
    writeStore(folder_ / "a.lode", model);
    startServer();
  }
};

TEST_F(DrawnWithinMemory, countsTheCopiesOnTheGpuInTheMemoryThatAllDrawFrom) {
  constexpr uint64_t kMemoryBytes = 32u << 20;
  const render::MemoryShares memory = render::shareMemory(kMemoryBytes);
  stream::StreamOptions options = threads(1);
  options.memory_budget_bytes = memory.stream_bytes;
  options.drawn_budget_bytes = memory.drawn_bytes;
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
