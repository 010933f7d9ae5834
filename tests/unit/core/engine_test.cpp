#include "client/core/engine.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/unit/core/engine_fixture.h"

namespace lode::core {
namespace {

TEST_F(EngineTest, showsTheRootsCoarsestLodFromUnrequestedBlobs) {
  openAndShowCoarse();
  ASSERT_TRUE(engine_.summary());
  ASSERT_TRUE(engine_.cut());
  EXPECT_EQ(engine_.cut()->triangles, 4u);
  EXPECT_FALSE(engine_.cut()->converged);
  EXPECT_EQ(engine_.cut()->blob_bytes, blobs_[1].size());
}

TEST_F(EngineTest, convergesWhenTheRequestedPayloadArrives) {
  const uint32_t request = openAndShowCoarse();
  ASSERT_NE(request, 0u);
  engine_.receive(blobFrame(request, 1), kStart);
  decodeAll();
  engine_.step(kStart);
  EXPECT_EQ(engine_.cut()->triangles, 40u);
  EXPECT_TRUE(engine_.cut()->converged);
  EXPECT_TRUE(engine_.settled());
  EXPECT_EQ(engine_.counts().open_requests, 0u);
}

TEST_F(EngineTest, repeatsACancelledRequestThatIsWantedAgain) {
  const uint32_t request = openAndShowCoarse();
  engine_.setView(view_, 1e6f);  // too coarse to need it
  engine_.step(kStart);
  engine_.setView(view_, 1);
  engine_.step(kStart);
  engine_.takeOutgoing();
  engine_.receive(proto::encode(proto::Cancelled{request}, 0), kStart);
  engine_.step(kStart);
  EXPECT_EQ(engine_.counts().open_requests, 1u);
  EXPECT_FALSE(engine_.takeOutgoing().empty());
}

TEST_F(EngineTest, doesNotRepeatARequestDuringDecoding) {
  const uint32_t request = openAndShowCoarse();
  engine_.receive(blobFrame(request, 1), kStart);
  engine_.step(kStart);
  EXPECT_EQ(engine_.counts().decoding, 1u);
  EXPECT_EQ(engine_.counts().open_requests, 0u);
}

TEST_F(EngineTest, repeatsARequestForATemporarilyUnreadableBlobAfterAPause) {
  uint32_t request = openAndShowCoarse();
  TimePoint now = kStart;
  std::chrono::seconds last_pause(0);
  for (int time = 0; time < 5; ++time) {
    engine_.receive(unreadable(request), now);
    engine_.step(now);
    EXPECT_EQ(engine_.failure(), "the server says: cannot be read");
    EXPECT_TRUE(engine_.failureMayPass());
    EXPECT_TRUE(engine_.settled()) << "nothing more comes for now";
    EXPECT_EQ(engine_.cut()->triangles, 4u);
    std::chrono::seconds pause(0);
    for (request = 0; request == 0; request = firstRequest()) engine_.step(now + ++pause);
    EXPECT_GE(pause, last_pause);
    EXPECT_LE(pause, kLastRepeat);
    now += last_pause = pause;
    EXPECT_FALSE(engine_.settled());
    EXPECT_TRUE(engine_.failureMayPass()) << "it is not there yet";
  }
  EXPECT_GT(last_pause, kFirstRepeat);
  engine_.receive(blobFrame(request, 1), now);
  decodeAll();
  engine_.step(now);
  EXPECT_EQ(engine_.failure(), "");
  EXPECT_TRUE(engine_.cut()->converged);
}

TEST_F(EngineTest, opensAModelWhoseFirstBlobsAreTemporarilyUnreadable) {
  for (const uint32_t arrived : {0u, 1u}) {  // unasked blobs that arrive before the error
    Engine engine(options());
    engine.setView(view_, 1);
    engine.connect(kStart);
    Bytes bytes = openingOf(arrived == 0 ? build_id_ : Digest());
    append(bytes, unreadable(0));
    engine.receive(bytes, kStart);
    engine.step(kStart);
    EXPECT_TRUE(engine.settled());
    EXPECT_EQ(engine.failure(), "the server says: cannot be read");
    EXPECT_TRUE(engine.connected());
    engine.takeOutgoing();
    TimePoint now = kStart + kFirstRepeat;
    for (const uint32_t blob : {3u, 2u, 1u}) {
      if (blob == 3 && arrived == 1) continue;
      engine.step(now);
      const uint32_t request = firstRequestOf(engine);
      ASSERT_NE(request, 0u) << blob;
      engine.receive(blobFrame(request, blob), now);
      for (const DecodeJob& job : engine.takeDecodeJobs()) engine.finishDecode(runDecodeJob(job));
    }
    engine.step(now);
    EXPECT_EQ(engine.failure(), "");
    ASSERT_TRUE(engine.cut());
    EXPECT_TRUE(engine.cut()->converged);
  }
}

TEST_F(EngineTest, forgetsAnUnreadableBlobThatTheViewNoLongerNeeds) {
  const uint32_t request = openAndShowCoarse();
  engine_.receive(unreadable(request), kStart);
  engine_.step(kStart);
  engine_.setView(view_, 1e6f);  // too coarse to need it
  TimePoint now = kStart;
  for (int second = 0; second < 5; ++second) engine_.step(now += std::chrono::seconds(1));
  EXPECT_EQ(engine_.failure(), "");
  EXPECT_TRUE(engine_.settled());
  EXPECT_EQ(firstRequest(), 0u);
}

TEST_F(EngineTest, keepsTheLastCutAndReportsAnUnavailableBlob) {
  const uint32_t request = openAndShowCoarse();
  engine_.receive(
      proto::encode(proto::ErrorMessage{proto::WireError::kDamagedStore, request, false, "damaged"}, 0),
      kStart);
  engine_.step(kStart);
  EXPECT_NE(engine_.failure().find("damaged"), std::string::npos);
  EXPECT_EQ(engine_.cut()->triangles, 4u);
  EXPECT_TRUE(engine_.settled()) << "nothing more will come";
  EXPECT_FALSE(engine_.cut()->converged);
  EXPECT_EQ(engine_.counts().open_requests, 0u);
}

TEST_F(EngineTest, beginsWithAFinerLodWhereTheCoarsestIsDamaged) {
  openWithoutTheCoarsest();
  engine_.receive(blobFrame(firstRequest(), 1), kStart);
  decodeAll();
  engine_.step(kStart);
  ASSERT_TRUE(engine_.cut());
  EXPECT_EQ(engine_.cut()->triangles, 40u);
  EXPECT_TRUE(engine_.cut()->converged);
}

TEST_F(EngineTest, settlesWithoutAPictureIfNoBlobIsAvailable) {
  openWithoutTheCoarsest();
  EXPECT_FALSE(engine_.settled());
  engine_.receive(
      proto::encode(proto::ErrorMessage{proto::WireError::kDamagedStore, firstRequest(), false, "damaged"},
                    0),
      kStart);
  engine_.step(kStart);
  EXPECT_FALSE(engine_.cut());
  EXPECT_TRUE(engine_.settled());
}

TEST_F(EngineTest, keepsTheLastCutAndReportsAnUndecodablePayload) {
  const uint32_t request = openAndShowCoarse();
  engine_.receive(blobFrame(request, 1), kStart);
  for (const DecodeJob& job : engine_.takeDecodeJobs())
    engine_.finishDecode({job.blob, job.use, nullptr, nullptr, nullptr, "broken"});
  engine_.step(kStart);
  EXPECT_NE(engine_.failure().find("broken"), std::string::npos);
  EXPECT_EQ(engine_.cut()->triangles, 4u);
  EXPECT_EQ(engine_.counts().open_requests, 0u);
}

TEST_F(EngineTest, aJobWithBytesThatAreNoPayloadFailsWithoutThrowing) {
  const DecodeResult result = runDecodeJob({{}, {}, Bytes(50), 1, {}});
  EXPECT_FALSE(result.decoded);
  EXPECT_FALSE(result.failure.empty());
}

TEST_F(EngineTest, givesUpOnAnInvalidPage) {
  blobs_[2] = Bytes(64);
  engine_.setView(view_, 1);
  engine_.connect(kStart);
  EXPECT_THROW(engine_.receive(greeting(), kStart), Error);
}

TEST_F(EngineTest, keepsThePictureAndReconnectsWhenTheServerGoesAway) {
  openAndShowCoarse();
  engine_.receive(proto::encode(proto::GoAway{"drain"}, 0), kStart);
  EXPECT_FALSE(engine_.wantsConnection(kStart));
  EXPECT_TRUE(engine_.wantsConnection(kStart + kMoveOn));
  engine_.step(kStart);
  EXPECT_EQ(engine_.cut()->triangles, 4u);
}

TEST_F(EngineTest, receivesOpenRequestsFromADrainingServer) {
  const uint32_t request = moveOn();
  EXPECT_TRUE(engine_.takeOutgoing().empty()) << "it asks for the blob a second time";
  engine_.receive(blobFrame(request, 1), kMoved, SessionRole::kDraining);
  engine_.disconnect(Error(ErrorCode::kNetwork, "closed"), kMoved, SessionRole::kDraining);
  decodeAll();
  engine_.step(kMoved);
  EXPECT_TRUE(engine_.settled());
  EXPECT_TRUE(engine_.connected());
  EXPECT_EQ(engine_.trouble(), "");
}

TEST_F(EngineTest, repeatsUnansweredRequestsAtTheNextServer) {
  moveOn();
  engine_.takeOutgoing();
  engine_.disconnect(Error(ErrorCode::kNetwork, "closed"), kMoved, SessionRole::kDraining);
  engine_.step(kMoved);
  EXPECT_EQ(engine_.counts().open_requests, 1u);
  engine_.receive(blobFrame(1, 1), kMoved);
  decodeAll();
  engine_.step(kMoved);
  EXPECT_TRUE(engine_.settled());
}

TEST_F(EngineTest, keepsTheDrainingServerUntilTheNextOneConnects) {
  const uint32_t request = openAndShowCoarse();
  engine_.receive(proto::encode(proto::GoAway{"drain"}, 0), kStart);
  engine_.connect(kMoved);
  engine_.disconnect(Error(ErrorCode::kNetwork, "refused"), kMoved);
  EXPECT_EQ(engine_.trouble(), "refused");
  engine_.connect(kMoved + kFirstRetry);
  engine_.receive(blobFrame(request, 1), kMoved + kFirstRetry, SessionRole::kDraining);
  decodeAll();
  engine_.step(kMoved + kFirstRetry);
  EXPECT_TRUE(engine_.cut()->converged);
}

TEST_F(EngineTest, triesAgainWhereTheServerIsFull) {
  engine_.setView(view_, 1);
  engine_.connect(kStart);
  engine_.receive(proto::encode(proto::ErrorMessage{proto::WireError::kLimit, 0, true, "no room"}, 0),
                  kStart);
  EXPECT_FALSE(engine_.connected());
  EXPECT_EQ(engine_.trouble(), "the server says: no room");
  EXPECT_FALSE(engine_.wantsConnection(kStart));
  ASSERT_TRUE(engine_.wantsConnection(kStart + kFirstRetry));
  engine_.connect(kStart + kFirstRetry);
  engine_.receive(greeting(), kStart + kFirstRetry);
  EXPECT_EQ(engine_.trouble(), "");
  EXPECT_TRUE(engine_.summary());
}

TEST_F(EngineTest, measuresWhatThePictureWaitsFor) {
  using std::chrono::milliseconds;
  const auto waited = [this](Waiting waiting) {
    return std::chrono::duration_cast<milliseconds>(engine_.counts().waited.of(waiting));
  };
  const uint32_t request = openAndShowCoarse();
  engine_.receive(blobFrame(request, 1), kStart + milliseconds(100));
  engine_.step(kStart + milliseconds(100));
  EXPECT_EQ(waited(Waiting::kLink), milliseconds(100));
  decodeAll();
  engine_.step(kStart + milliseconds(250));
  engine_.step(kStart + milliseconds(900));
  EXPECT_EQ(waited(Waiting::kLink), milliseconds(100));
  EXPECT_EQ(waited(Waiting::kDecode), milliseconds(150));
  EXPECT_EQ(waited(Waiting::kBudget), milliseconds(0));
}

TEST_F(EngineTest, repeatsOpenRequestsAfterTheConnectionBroke) {
  openAndShowCoarse();
  engine_.disconnect(Error(ErrorCode::kNetwork, "broken"), kStart);
  engine_.connect(kStart + kFirstRetry);
  engine_.receive(greeting(build_id_), kStart + kFirstRetry);
  decodeAll();
  engine_.step(kStart + kFirstRetry);
  EXPECT_EQ(engine_.trouble(), "");
  EXPECT_EQ(engine_.counts().open_requests, 1u);
  EXPECT_EQ(engine_.cut()->triangles, 4u);
}

TEST_F(EngineTest, keepsThePictureAndReconnectsWhenTheServerFallsSilent) {
  openAndShowCoarse();
  TimePoint now = kStart;
  for (int second = 0; second < 40 && engine_.trouble().empty(); ++second)
    engine_.step(now += std::chrono::seconds(1));
  EXPECT_NE(engine_.trouble(), "");
  EXPECT_EQ(engine_.cut()->triangles, 4u);
  EXPECT_TRUE(engine_.wantsConnection(now + kFirstRetry));
}

TEST_F(EngineTest, givesUpOnErrorsThatARetryWouldRepeat) {
  EXPECT_THROW(engine_.disconnect(Error(ErrorCode::kNetwork, "nobody there"), kStart), Error);
  openAndShowCoarse();
  EXPECT_THROW(engine_.disconnect(Error(ErrorCode::kInput, "no such model"), kStart), Error);
}

TEST_F(EngineTest, fetchesABlobOfTwoLodsOnceWhicheverIsWantedFirst) {
  root_.lods = {{refOf(1), 40, 42, 0, 0.001f, 0}, {refOf(1), 40, 42, 0, 0.04f, 0}, root_.lods[1]};
  blobs_[2] = encodePage({{root_}});
  const uint32_t request = openAndShowCoarse();
  engine_.receive(blobFrame(request, 1), kStart);
  decodeAll();
  engine_.step(kStart);
  ASSERT_EQ(engine_.cut()->parts.at(0).lod, 1u);
  engine_.setView(view_, 0.1f);
  engine_.step(kStart);
  EXPECT_EQ(engine_.counts().open_requests, 0u);
  EXPECT_EQ(engine_.cut()->parts.at(0).lod, 0u);
  EXPECT_TRUE(engine_.settled());
}

TEST_F(EngineTest, fetchesABlobOfTwoLodsOnce) {
  root_.lods = {{refOf(1), 40, 42, 0, 0.001f, 0}, {refOf(1), 40, 42, 0, 0.002f, 0}, root_.lods[1]};
  blobs_[2] = encodePage({{root_}});
  const uint32_t request = openAndShowCoarse();
  engine_.receive(blobFrame(request, 1), kStart);
  decodeAll();
  engine_.step(kStart);
  engine_.setView(view_, 0.5f);
  engine_.step(kStart);
  EXPECT_TRUE(engine_.settled());
}

TEST_F(EngineTest, fetchesABlobOfTwoNodesOnce) {
  Node left = root_, right = root_;
  left.key = kRootKey.child(0);
  right.key = kRootKey.child(1);
  left.lods = right.lods = {root_.lods[0]};
  root_.lods.erase(root_.lods.begin());
  root_.child_mask = 0b11;
  nodes_ = 3;
  blobs_[2] = encodePage({{root_, left, right}});
  const uint32_t request = openAndShowCoarse();
  engine_.receive(blobFrame(request, 1), kStart);
  engine_.step(kStart);
  EXPECT_EQ(engine_.counts().open_requests, 0u);
  decodeAll();
  engine_.step(kStart);
  EXPECT_EQ(engine_.cut()->parts.size(), 2u);
  EXPECT_TRUE(engine_.settled());
}

}  // namespace
}  // namespace lode::core
