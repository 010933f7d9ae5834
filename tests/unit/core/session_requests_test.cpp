#include <gtest/gtest.h>

#include "client/core/session/session.h"
#include "tests/unit/core/session_fixture.h"

namespace lode::core {
namespace {

using namespace fixture;

TEST_F(SessionTest, requestsOnceABlobAndDeliversItsBytes) {
  open();
  const BlobRef blob = blobRef(5, 50'000);
  const uint32_t request = makeRequest(blob);
  EXPECT_NE(request, 0u);
  EXPECT_EQ(makeRequest(blob), 0u);
  const auto events = give(blobFrames(request, 5, 50'000));
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(std::get<BlobArrived>(events[0]).blob, blob);
  EXPECT_EQ(std::get<BlobArrived>(events[0]).bytes, blobBytes(5, 50'000));
  EXPECT_EQ(session_.openRequests(), 0u);
  EXPECT_EQ(session_.requestedBytes(), 0u);
}

TEST_F(SessionTest, countsOpenRequestsByTheirClassAndThoseForTiles) {
  open();
  const BlobRef mesh = blobRef(5, 100), tile = blobRef(6, 100), ahead = blobRef(7, 100);
  const BlobUse of_tile{BlobKind::kTile, {}};
  session_.setRequests(std::vector<Request>{{mesh, {}, proto::RequestClass::kVisible, 10},
                                            {tile, of_tile, proto::RequestClass::kMargin, 10},
                                            {ahead, {}, proto::RequestClass::kPrefetch, 10}});
  EXPECT_EQ(session_.requestCounts(), (RequestCounts{1, 1, 1, 1}));
  session_.setRequests(std::vector<Request>{{mesh, {}, proto::RequestClass::kVisible, 10},
                                            {tile, of_tile, proto::RequestClass::kVisible, 10}});
  EXPECT_EQ(session_.requestCounts(), (RequestCounts{2, 0, 1, 1}))
      << "what is taken back is open until it has ended";
  const auto changes = changesOf(session_.takeOutgoing());
  for (const auto& change : changes)
    if (change.action == proto::RequestAction::kCancel)
      give(proto::encode(proto::Cancelled{change.request}, 0));
  EXPECT_EQ(session_.requestCounts(), (RequestCounts{2, 0, 0, 1}));
  give(blobFrames(2, 6, 100));
  EXPECT_EQ(session_.requestCounts(), (RequestCounts{1, 0, 0, 0}));
}

TEST_F(SessionTest, sendsAChangeOfPriorityOnlyIfItIsLarge) {
  open();
  const BlobRef blob = blobRef(5, 100);
  makeRequest(blob);
  session_.setRequests(std::vector<Request>{{blob, {}, proto::RequestClass::kVisible, 11}});
  EXPECT_TRUE(changesOf(session_.takeOutgoing()).empty());
  session_.setRequests(std::vector<Request>{{blob, {}, proto::RequestClass::kVisible, 20}});
  const auto changes = changesOf(session_.takeOutgoing());
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].action, proto::RequestAction::kReprioritise);
  EXPECT_EQ(changes[0].priority_px, 20);
}

TEST_F(SessionTest, cancelsUnwantedRequestsAndEndsThemOnce) {
  open();
  const BlobRef blob = blobRef(5, 100);
  const uint32_t request = makeRequest(blob);
  session_.setRequests({});
  const auto changes = changesOf(session_.takeOutgoing());
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].action, proto::RequestAction::kCancel);
  session_.setRequests({});
  EXPECT_TRUE(changesOf(session_.takeOutgoing()).empty());
  give(proto::encode(proto::Cancelled{request}, 0));
  EXPECT_EQ(session_.openRequests(), 0u);
  EXPECT_EQ(session_.requestedBytes(), 0u);
  expectRefused(proto::encode(proto::Cancelled{request}, 0), "cancelled");
}

TEST_F(SessionTest, acceptsABlobThatCompletesDuringItsCancellation) {
  open();
  const uint32_t request = makeRequest(blobRef(5, 100));
  session_.setRequests({});
  EXPECT_EQ(give(blobFrames(request, 5, 100)).size(), 1u);
  EXPECT_EQ(session_.openRequests(), 0u);
}

TEST_F(SessionTest, requestsAgainOnlyAfterACancelledRequestHasEnded) {
  open();
  const BlobRef blob = blobRef(5, 100);
  const uint32_t request = makeRequest(blob);
  session_.setRequests({});
  session_.takeOutgoing();
  EXPECT_EQ(makeRequest(blob), 0u);
  give(proto::encode(proto::Cancelled{request}, 0));
  EXPECT_NE(makeRequest(blob), 0u);
}

TEST_F(SessionTest, sendsNoMoreChangesOfACancelledRequest) {
  open();
  const BlobRef blob = blobRef(5, 100);
  makeRequest(blob);
  session_.setRequests({});
  session_.takeOutgoing();
  session_.setRequests(std::vector<Request>{{blob, {}, proto::RequestClass::kMargin, 1000}});
  EXPECT_TRUE(changesOf(session_.takeOutgoing()).empty());
}

TEST_F(SessionTest, reportsARequestThatTheServerRefuses) {
  open();
  const BlobRef blob = blobRef(5, 100);
  const uint32_t request = makeRequest(blob);
  const auto events =
      give(proto::encode(proto::ErrorMessage{proto::WireError::kDamagedStore, request, false, "damaged"}, 0));
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(std::get<BlobRefused>(events[0]).blob, blob);
  EXPECT_EQ(session_.openRequests(), 0u);
}

TEST_F(SessionTest, distinguishesLostFromTemporarilyRefusedBlobs) {
  open();
  const BlobRef blob = blobRef(5, 100);
  const std::pair<proto::WireError, bool> errors[] = {{proto::WireError::kDamagedStore, true},
                                                      {proto::WireError::kNoSuchBlob, true},
                                                      {proto::WireError::kNotReady, false},
                                                      {proto::WireError::kInternal, false}};
  for (const auto& [code, is_lost] : errors) {
    const auto events = give(proto::encode(proto::ErrorMessage{code, makeRequest(blob), false, "no"}, 0));
    ASSERT_EQ(events.size(), 1u);
    EXPECT_EQ(std::get<BlobRefused>(events[0]).is_lost, is_lost) << static_cast<int>(code);
  }
}

TEST_F(SessionTest, requestsATemporarilyUnreadableFirstBlobLater) {
  for (const auto code : {proto::WireError::kInternal, proto::WireError::kNotReady}) {
    Session session(optionsFor("model"), kStart);
    session.receive(welcome() + opened() + proto::encode(proto::ErrorMessage{code, 0, false, "no"}, 2),
                    kStart);
    ASSERT_TRUE(std::holds_alternative<ModelOpened>(session.nextEvent().value()));
    EXPECT_TRUE(session.givesFirstBlobs());
    const auto refused = std::get<BlobRefused>(session.nextEvent().value());
    EXPECT_EQ(refused.blob.number, kPageBlob);
    EXPECT_FALSE(refused.is_lost);
    EXPECT_FALSE(session.givesFirstBlobs());
    session.takeOutgoing();
    session.setRequests(std::vector<Request>{{refused.blob, refused.use, proto::RequestClass::kVisible, 10}});
    EXPECT_EQ(changesOf(session.takeOutgoing()).size(), 1u);
  }
}

TEST_F(SessionTest, keepsRequestsWithinItsLimitOfBytes) {
  SessionOptions options = optionsFor("model");
  options.max_requested_bytes = 1000;
  Session session(options, kStart);
  session.receive(welcome() + opened(), kStart);
  while (session.nextEvent()) {
  }
  std::vector<Request> requests;
  for (uint32_t i = 0; i < 10; ++i)
    requests.push_back({blobRef(10 + i, 400), {}, proto::RequestClass::kVisible, 1});
  session.setRequests(requests);
  EXPECT_EQ(session.openRequests(), 2u);
  EXPECT_LE(session.requestedBytes(), 1000u);
}

TEST_F(SessionTest, doesNotCountCancelledRequestsInItsLimits) {
  SessionOptions options = optionsFor("model");
  options.max_requested_bytes = 1000;
  Session session(options, kStart);
  session.receive(welcome() + opened(), kStart);
  while (session.nextEvent()) {
  }
  session.setRequests(std::vector<Request>{{blobRef(10, 1000)}});
  session.takeOutgoing();
  session.setRequests(std::vector<Request>{{blobRef(11, 1000)}});
  const auto changes = changesOf(session.takeOutgoing());
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].action, proto::RequestAction::kCancel);
  EXPECT_EQ(changes[1].action, proto::RequestAction::kAdd);
}

TEST_F(SessionTest, requestsABlobLargerThanTheLimitAlone) {
  SessionOptions options = optionsFor("model");
  options.max_requested_bytes = 1000;
  Session session(options, kStart);
  session.receive(welcome() + opened(), kStart);
  while (session.nextEvent()) {
  }
  session.setRequests(std::vector<Request>{{blobRef(10, 4000)}, {blobRef(11, 10)}});
  EXPECT_EQ(session.openRequests(), 1u);
}

TEST_F(SessionTest, keepsRequestsWithinTheNumberThatTheServerAllows) {
  Session session(optionsFor("model"), kStart);
  session.receive(proto::encode(proto::Welcome{proto::kProtocolVersion, 0, 3, "test"}, 1) + opened(), kStart);
  while (session.nextEvent()) {
  }
  std::vector<Request> requests;
  for (uint32_t i = 0; i < 10; ++i)
    requests.push_back({blobRef(10 + i, 4), {}, proto::RequestClass::kVisible, 1});
  session.setRequests(requests);
  EXPECT_EQ(session.openRequests(), 3u);
}

TEST_F(SessionTest, keepsTheGrantAWindowAheadOfReceivedBytes) {
  open();
  constexpr size_t kSize = 3u << 20;
  const uint32_t request = makeRequest(blobRef(5, kSize));
  const Bytes frames = blobFrames(request, 5, kSize);
  uint64_t sent = kPageBytes + proto::kBlobChunkHeaderBytes, granted = proto::kInitialWindowBytes;
  for (const SentFrame& frame : framesOf(frames)) {
    sent += frame.body.size();
    ASSERT_LE(sent, granted);
    give(frameOf(FrameType::kBlob, 0, frame.body));
    for (const auto& credit : messagesOf<proto::Credit>(session_.takeOutgoing(), FrameType::kCredit)) {
      EXPECT_GT(credit.granted_bytes, granted);
      granted = credit.granted_bytes;
    }
    EXPECT_EQ(granted, sent + session_.window().bytes());
  }
  EXPECT_EQ(session_.openRequests(), 0u);
}

TEST_F(SessionTest, grantsMoreBeforeAChunkIsComplete) {
  open();
  const uint32_t request = makeRequest(blobRef(5, proto::kMaxChunkBytes));
  const Bytes frame = blobFrames(request, 5, proto::kMaxChunkBytes);
  give({frame.begin(), frame.begin() + frame.size() / 2});
  const auto credits = messagesOf<proto::Credit>(session_.takeOutgoing(), FrameType::kCredit);
  ASSERT_EQ(credits.size(), 1u);
  EXPECT_GE(credits[0].granted_bytes, proto::kInitialWindowBytes + frame.size() / 2);
}

/// Simulates half a second of a link with a rate in bytes per millisecond.
TEST_F(SessionTest, grantsTheMeasuredCapacityOfTheLink) {
  open();
  give(proto::encode(proto::Pong{1}, 0), kStart + std::chrono::milliseconds(100));
  constexpr size_t kSize = 16u << 20;
  const uint32_t request = makeRequest(blobRef(5, kSize));
  const Bytes frames = blobFrames(request, 5, kSize);
  constexpr size_t kBytesPerMs = 10'000;
  size_t at = 0;
  for (int ms = 0; ms < 1500 && at + kBytesPerMs < frames.size(); ++ms, at += kBytesPerMs) {
    session_.takeOutgoing();
    const auto begin = frames.begin() + static_cast<ptrdiff_t>(at);
    give({begin, begin + kBytesPerMs}, kStart + std::chrono::milliseconds(100 + ms));
  }
  const double expected = 1.5 * kBytesPerMs * 100;
  EXPECT_NEAR(static_cast<double>(session_.window().bytes()), expected, 0.02 * expected);
}

TEST_F(SessionTest, cancelsLowerClassesToMakeRoomForHigherOnes) {
  Session session(optionsFor("model"), kStart);
  session.receive(proto::encode(proto::Welcome{proto::kProtocolVersion, 0, 3, "test"}, 1) + opened(), kStart);
  while (session.nextEvent()) {
  }
  std::vector<Request> requests;
  for (uint32_t i = 0; i < 3; ++i)
    requests.push_back({blobRef(10 + i, 4), {}, proto::RequestClass::kPrefetch, 1});
  session.setRequests(requests);
  session.takeOutgoing();
  requests.insert(requests.begin(), {blobRef(20, 4), {}, proto::RequestClass::kVisible, 1});
  session.setRequests(requests);
  const auto changes = changesOf(session.takeOutgoing());
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].action, proto::RequestAction::kCancel);
  EXPECT_EQ(changes[1].action, proto::RequestAction::kAdd);
  EXPECT_EQ(changes[1].blob, 20u);
}

}  // namespace
}  // namespace lode::core
