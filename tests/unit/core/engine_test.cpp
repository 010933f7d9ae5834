#include "client/core/engine.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "proto/limits.h"
#include "tests/unit/core/session_fixture.h"

namespace lode::core {
namespace {

using proto::Bytes;

using fixture::kStart;

/// Returns triangles in the plane z = 0; their number identifies the LOD.
Mesh stripOf(uint32_t triangles) {
  Mesh mesh;
  for (uint32_t i = 0; i < triangles + 2; ++i) mesh.positions.push_back(packPosition({i / 2, i % 2, 0}));
  for (uint32_t i = 0; i < triangles; ++i)
    mesh.triangles.push_back(i % 2 == 0 ? glm::u32vec3(i, i + 1, i + 2) : glm::u32vec3(i + 1, i, i + 2));
  return mesh;
}

/// A model of one node with two LODs, and its server as bytes in process.
class EngineTest : public testing::Test {
 protected:
  void SetUp() override {
    const EncodedPayload fine = encodePayload(stripOf(40), 1), coarse = encodePayload(stripOf(4), 1);
    blobs_ = {fine.bytes, coarse.bytes};
    root_.key = kRootKey;
    root_.box.add(glm::uvec3(0));
    root_.box.add(glm::uvec3(21, 1, 0));
    root_.lods = {{refOf(1), 40, fine.vertices, 0, 0.001f, 0}, {refOf(2), 4, coarse.vertices, 0, 10, 0}};
    blobs_.push_back(encodePage({{root_}}));
    view_.eye_model = {10, 0, 40};
  }

  BlobRef refOf(uint32_t number) const {
    const Bytes& blob = blobs_[number - 1];
    return {number, static_cast<uint32_t>(blob.size()), digestOf(blob)};
  }

  static void append(Bytes& to, const Bytes& more) { to.insert(to.end(), more.begin(), more.end()); }

  Bytes blobFrame(uint32_t request, uint32_t number) const {
    const Bytes& blob = blobs_[number - 1];
    const auto fields = proto::encodeBlobChunkHeader({request, static_cast<uint32_t>(blob.size()), 0});
    const auto header = proto::encodeFrameHeader({static_cast<uint32_t>(fields.size() + blob.size()),
                                                  static_cast<uint8_t>(proto::FrameType::kBlob), 0, 0});
    Bytes frame(header.size() + fields.size() + blob.size());
    auto at = std::copy(header.begin(), header.end(), frame.begin());
    at = std::copy(fields.begin(), fields.end(), at);
    std::copy(blob.begin(), blob.end(), at);
    return frame;
  }

  /// Opens the model and receives the root page.
  Bytes openingOf(const Digest& known) const {
    proto::Opened opened;
    opened.handle = 1;
    opened.summary.name = "strip";
    opened.summary.nodes = nodes_;
    opened.summary.build_id = build_id_;
    opened.summary.lattice.step = step_;
    opened.summary.root_page = refOf(3);
    Bytes bytes = proto::encode(proto::Welcome{proto::kProtocolVersion, 0, 100, ""}, 1);
    append(bytes, proto::encode(opened, 2));
    if (known != build_id_) append(bytes, blobFrame(0, 3));
    return bytes;
  }

  /// @param known  the build that the client has: the server sends no blobs of it without a request.
  Bytes greeting(const Digest& known = {}) const {
    Bytes bytes = openingOf(known);
    if (known != build_id_) append(bytes, blobFrame(0, 2));
    return bytes;
  }

  void decodeAll() {
    for (const DecodeJob& job : engine_.takeDecodeJobs()) engine_.finishDecode(runDecodeJob(job));
  }

  /// Returns the request for the fine LOD once the coarse one is shown.
  uint32_t openAndShowCoarse() {
    engine_.setView(view_, 1);
    engine_.connect(kStart);
    engine_.receive(greeting(), kStart);
    engine_.takeOutgoing();
    decodeAll();
    engine_.step(kStart);
    return firstRequest();
  }

  /// Returns the request in the bytes that the engine sends now; 0: none.
  uint32_t firstRequest() { return firstRequestOf(engine_); }
  uint32_t firstRequestOf(Engine& engine) {
    uint32_t request = 0;
    std::span<const std::byte> rest = sent_ = engine.takeOutgoing();
    while (!rest.empty()) {
      const auto header = proto::decodeFrameHeader(rest.first<proto::kFrameHeaderBytes>());
      if (header.type == static_cast<uint8_t>(proto::FrameType::kRequests))
        request = proto::decode<proto::Requests>(rest.subspan(proto::kFrameHeaderBytes, header.body_bytes))
                      .changes.at(0)
                      .request;
      rest = rest.subspan(proto::kFrameHeaderBytes + header.body_bytes);
    }
    return request;
  }

  /// Refuses a request, or with 0 an unasked blob, because the store cannot be read now.
  static Bytes unreadable(uint32_t request) {
    return proto::encode(proto::ErrorMessage{proto::WireError::kInternal, request, false, "cannot be read"},
                         2);
  }

  /// Refuses a request because the store is damaged.
  void openWithoutTheCoarsest() {
    engine_.setView(view_, 1000);
    engine_.connect(kStart);
    Bytes bytes = openingOf({});
    append(bytes,
           proto::encode(proto::ErrorMessage{proto::WireError::kDamagedStore, 0, false, "damaged"}, 2));
    engine_.receive(bytes, kStart);
    engine_.step(kStart);
  }

  static constexpr TimePoint kMoved = kStart + kMoveOn;

  /// The server shuts down with an open request while the next one is connected. @return the request.
  uint32_t moveOn() {
    const uint32_t request = openAndShowCoarse();
    engine_.receive(proto::encode(proto::GoAway{"drain"}, 0), kStart);
    EXPECT_TRUE(engine_.wantsConnection(kMoved));
    engine_.connect(kMoved);
    engine_.takeOutgoing();
    engine_.receive(greeting(build_id_), kMoved);
    engine_.takeOutgoing();
    engine_.step(kMoved);
    return request;
  }

  static EngineOptions options() {
    EngineOptions options;
    options.session.model = "strip";
    return options;
  }

  std::vector<Bytes> blobs_;
  Node root_;
  Digest build_id_{{std::byte{1}}};
  uint32_t nodes_ = 1;
  double step_ = Lattice{}.step;
  View view_;
  Bytes sent_;
  Engine engine_{options()};
};

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

TEST_F(EngineTest, keepsThePictureAndReconnectsWhenTheServerFallsSilent) {
  openAndShowCoarse();
  TimePoint now = kStart;
  for (int second = 0; second < 40 && engine_.trouble().empty(); ++second)
    engine_.step(now += std::chrono::seconds(1));
  EXPECT_NE(engine_.trouble(), "");
  EXPECT_EQ(engine_.cut()->triangles, 4u);
  EXPECT_TRUE(engine_.wantsConnection(now + kFirstRetry));
}

TEST_F(EngineTest, requestsNoBlobsOfTheOldBuildFromAServerOfTheNew) {
  openAndShowCoarse();
  ASSERT_EQ(engine_.counts().open_requests, 1u);
  engine_.receive(proto::encode(proto::ModelReplaced{1}, 0), kStart);
  engine_.connect(kStart);
  build_id_.bytes[0] = std::byte{2};
  engine_.receive(greeting(build_id_), kStart);  // its first blobs are in transit
  engine_.step(kStart);
  EXPECT_EQ(engine_.counts().open_requests, 0u);
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
