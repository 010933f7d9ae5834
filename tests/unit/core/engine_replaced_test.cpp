#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/unit/core/engine_fixture.h"

/// Tests of an engine whose server replaces the model by another build.
namespace lode::core {
namespace {

TEST_F(EngineTest, showsTheOldBuildUntilTheNewOneIsOpen) {
  openAndShowCoarse();
  engine_.receive(proto::encode(proto::ModelReplaced{1}, 0), kStart);
  EXPECT_TRUE(engine_.wantsConnection(kStart));
  engine_.connect(kStart);
  build_id_.bytes[0] = std::byte{2};
  engine_.receive(greeting(), kStart);
  engine_.step(kStart);
  EXPECT_EQ(engine_.cut()->triangles, 4u);
  EXPECT_EQ(engine_.summary()->build_id, build_id_);
  decodeAll();
  engine_.step(kStart);
  EXPECT_EQ(engine_.counts().open_requests, 1u);
}

TEST_F(EngineTest, refusesANewBuildOfAnotherSize) {
  openAndShowCoarse();
  engine_.receive(proto::encode(proto::ModelReplaced{1}, 0), kStart);
  engine_.connect(kStart);
  build_id_.bytes[0] = std::byte{2};
  step_ *= 2;
  try {
    engine_.receive(greeting(), kStart);
    FAIL() << "not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput);
    EXPECT_NE(std::string(error.what()).find("another size"), std::string::npos) << error.what();
  }
}

TEST_F(EngineTest, requestsNoBlobsOfTheOldBuildFromAServerOfTheNew) {
  openAndShowCoarse();
  ASSERT_EQ(engine_.counts().open_requests, 1u);
  engine_.receive(proto::encode(proto::ModelReplaced{1}, 0), kStart);
  engine_.connect(kStart);
  build_id_.bytes[0] = std::byte{2};
  engine_.receive(greeting(build_id_), kStart);  // the first blobs of the new build are in transit
  engine_.step(kStart);
  EXPECT_EQ(engine_.counts().open_requests, 0u);
}

/// The model is replaced while its fine LOD is shown, and the new build has shown its coarse LOD.
class EngineWithASharpCut : public EngineTest {
 protected:
  void SetUp() override {
    EngineTest::SetUp();
    show(openAndShowCoarse());
    engine_.receive(proto::encode(proto::ModelReplaced{1}, 0), kStart);
    engine_.connect(kStart);
    build_id_.bytes[0] = std::byte{2};
    engine_.receive(greeting(), kStart);
    decodeAll();
    engine_.step(kStart);
  }
  /// Answers the request for the fine LOD.
  void show(uint32_t request) {
    engine_.receive(blobFrame(request, 1), kStart);
    decodeAll();
    engine_.step(kStart);
  }
};

TEST_F(EngineWithASharpCut, keepsItUntilTheNewBuildIsAsSharp) {
  const uint64_t before = engine_.cutBuild();
  EXPECT_EQ(engine_.cut()->triangles, 40u);
  EXPECT_FALSE(engine_.settled());
  show(firstRequest());
  EXPECT_NE(engine_.cutBuild(), before);
  EXPECT_EQ(engine_.cut()->triangles, 40u);
  EXPECT_TRUE(engine_.settled());
}

TEST_F(EngineWithASharpCut, showsTheNewBuildWhenTheViewChanges) {
  view_.eye_model.x += 1;
  engine_.setView(view_, 1);
  engine_.step(kStart);
  EXPECT_EQ(engine_.cut()->triangles, 4u);
}

TEST_F(EngineWithASharpCut, showsTheNewBuildWhenItIsFinal) {
  engine_.setView(view_, 1e6f);
  engine_.step(kStart);
  EXPECT_TRUE(engine_.settled());
  EXPECT_EQ(engine_.cut()->triangles, 4u);
}

}  // namespace
}  // namespace lode::core
