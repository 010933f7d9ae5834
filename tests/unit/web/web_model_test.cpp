#include "client/web/core/web_model.h"

#include <cmath>

#include "client/web/core/page_json.h"
#include "common/error.h"
#include "tests/unit/core/engine_fixture.h"

namespace lode::web {
namespace {

using core::kStart;

/// A page that shows the fixture's model: one node with an LOD of 4 triangles and one of 40.
class WebModelTest : public core::EngineTest {
 protected:
  static WebModelOptions optionsOf(const char* name) {
    WebModelOptions options;
    options.model = name;
    return options;
  }

  void openAndReceive() {
    core::Engine& engine = model_.engine();
    engine.connect(kStart);
    engine.receive(greeting(), kStart);
    work();
  }

  /// Decodes all jobs by messages, as workers do.
  void work() {
    for (int round = 0; round < 4; ++round) {
      model_.engine().step(kStart);
      while (const std::optional<Bytes> job = model_.takeJob()) {
        const JobMessage message = decodeJob(*job);
        model_.finishJob(encodeResult(message.number, core::runDecodeJob(message.job)));
      }
      model_.engine().step(kStart);
    }
  }

  FrameInput frame() const {
    FrameInput input;
    input.width_px = 400;
    input.height_px = 300;
    return input;
  }

  WebModel model_{optionsOf("strip")};
};

TEST_F(WebModelTest, framesTheModelByItsCoarsestMesh) {
  const CameraStart start{400, 300, std::nullopt, std::nullopt};
  EXPECT_FALSE(model_.startCamera(start)) << "nothing is known of the model";
  openAndReceive();
  while (!model_.startCamera(start)) work();
  model_.frame(frame());
  EXPECT_EQ(model_.rig().view().width_px, 400u);
  const std::optional<WebPick> middle = model_.pick({200, 150});
  ASSERT_TRUE(middle.has_value()) << "the model is in the middle of the picture";
  EXPECT_NEAR(middle->point.z, 0, 1e-9);
}

TEST_F(WebModelTest, refusesFramesAndPicksBeforeTheCamera) {
  EXPECT_THROW(model_.frame(frame()), Error) << "nothing is known of the model";
  openAndReceive();
  EXPECT_FALSE(model_.startCamera({400, 300, std::nullopt, std::nullopt}));
  EXPECT_THROW(model_.frame(frame()), Error);
  EXPECT_THROW(model_.pick({200, 150}), Error);
  EXPECT_THROW(model_.rig(), Error);
}

TEST_F(WebModelTest, requestsMeshesOfTheViewBeforeTheFirstFrame) {
  openAndReceive();
  model_.engine().takeOutgoing();
  ASSERT_TRUE(model_.startCamera(
      {400, 300, std::nullopt, core::CameraPath{45, {{0, {10, 0, 4}, {10, 0, 0}, {0, 1, 0}}}}}));
  model_.engine().step(kStart);
  EXPECT_FALSE(model_.engine().takeOutgoing().empty());
}

TEST_F(WebModelTest, listsTheMeshesOfTheCutUntilAnotherCutReplacesThem) {
  openAndReceive();
  CameraStart start{400, 300, std::nullopt, core::CameraPath{45, {{0, {10, 0, 40}, {10, 0, 0}, {0, 1, 0}}}}};
  ASSERT_TRUE(model_.startCamera(start));
  model_.frame(frame());
  work();
  model_.frame(frame());
  ASSERT_EQ(model_.parts().size(), 1u);
  const uint32_t id = model_.parts()[0].id;
  const uint64_t serial = model_.serial();
  EXPECT_EQ(model_.mesh(id)->triangles.size(), 4u);
  model_.frame(frame());
  EXPECT_EQ(model_.serial(), serial) << "nothing has changed";
  model_.engine().receive(blobFrame(firstRequestOf(model_.engine()), 1), kStart);
  work();
  model_.frame(frame());
  ASSERT_EQ(model_.parts().size(), 1u);
  EXPECT_NE(model_.parts()[0].id, id);
  EXPECT_EQ(model_.mesh(model_.parts()[0].id)->triangles.size(), 40u);
  EXPECT_EQ(model_.mesh(id), nullptr);
}

TEST_F(WebModelTest, keepsTheNearPlaneInFrontOfTheNearestSurface) {
  openAndReceive();
  CameraStart start{400, 300, std::nullopt, core::CameraPath{45, {{0, {10, 0, 40}, {10, 0, 0}, {0, 1, 0}}}}};
  ASSERT_TRUE(model_.startCamera(start));
  model_.frame(frame());
  work();
  model_.frame(frame());
  EXPECT_GT(model_.nearModel(), 10);
  EXPECT_LT(model_.nearModel(), 40);
}

TEST_F(WebModelTest, refusesTheResultOfNoJob) { EXPECT_THROW(model_.finishJob(encodeResult(9, {})), Error); }

TEST(PageJson, refusesWrongMembersWithAnError) {
  for (const char* text : {"", "{", "[]", R"({"model": 3})", R"({"model": "m", "memory_bytes": "much"})"})
    EXPECT_THROW(parseOptions(text), Error) << text;
  EXPECT_THROW(parseFrame(R"({"turned_px": 3})"), Error);
  EXPECT_THROW(parseCameraStart(R"({"camera": {"eye": [0, 0], "target": [0, 0, 0], "up": [0, 1, 0]}})"),
               Error);
}

TEST(PageJson, limitsSizesAndTimes) {
  const FrameInput frame =
      parseFrame(R"({"width_px": 1e9, "height_px": -4, "seconds": 1e9, "threshold_px": 0})");
  EXPECT_LE(frame.width_px, 16384u);
  EXPECT_EQ(frame.height_px, 1u);
  EXPECT_LE(frame.seconds, 1);
  EXPECT_GT(frame.threshold_px, 0);
}

TEST(PageJson, readsTheUsersInput) {
  const FrameInput frame = parseFrame(
      R"({"turned_px": [3, 4], "wheel": 2, "double_click_px": [10, 20], "fly": {"forward": 1, "fast": true}, "side": "top"})");
  EXPECT_EQ(frame.input.turned_px, glm::dvec2(3, 4));
  EXPECT_TRUE(frame.input.double_clicked);
  EXPECT_EQ(frame.input.pointer_px, glm::dvec2(10, 20));
  EXPECT_TRUE(frame.input.fly.fast);
  EXPECT_EQ(frame.input.side, core::Side::kTop);
}

}  // namespace
}  // namespace lode::web
