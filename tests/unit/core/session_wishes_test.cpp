#include <gtest/gtest.h>

#include "client/core/session.h"
#include "tests/unit/core/session_fixture.h"

namespace lode::core {
namespace {

using namespace fixture;

TEST_F(SessionTest, wishesOnceForABlobAndDeliversItsBytes) {
  open();
  const BlobRef blob = blobRef(5, 50'000);
  const uint32_t wish = wishFor(blob);
  EXPECT_NE(wish, 0u);
  EXPECT_EQ(wishFor(blob), 0u);
  const auto events = give(blobFrames(wish, 5, 50'000));
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(std::get<BlobArrived>(events[0]).blob, blob);
  EXPECT_EQ(std::get<BlobArrived>(events[0]).bytes, blobBytes(5, 50'000));
  EXPECT_EQ(session_.openWishes(), 0u);
  EXPECT_EQ(session_.wishedBytes(), 0u);
}

TEST_F(SessionTest, countsOpenWishesByTheirClassAndThoseForTiles) {
  open();
  const BlobRef mesh = blobRef(5, 100), tile = blobRef(6, 100), ahead = blobRef(7, 100);
  const BlobUse of_tile{BlobKind::kTile, {}};
  session_.setWishes(std::vector<Wish>{{mesh, {}, proto::WishClass::kVisible, 10},
                                       {tile, of_tile, proto::WishClass::kMargin, 10},
                                       {ahead, {}, proto::WishClass::kPrefetch, 10}});
  EXPECT_EQ(session_.wishCounts(), (WishCounts{1, 1, 1, 1}));
  session_.setWishes(std::vector<Wish>{{mesh, {}, proto::WishClass::kVisible, 10},
                                       {tile, of_tile, proto::WishClass::kVisible, 10}});
  EXPECT_EQ(session_.wishCounts(), (WishCounts{2, 0, 1, 1}))
      << "what is taken back is open until it has ended";
  const auto changes = changesOf(session_.takeOutgoing());
  for (const auto& change : changes)
    if (change.action == proto::WishAction::kCancel) give(proto::encode(proto::Cancelled{change.wish}, 0));
  EXPECT_EQ(session_.wishCounts(), (WishCounts{2, 0, 0, 1}));
  give(blobFrames(2, 6, 100));
  EXPECT_EQ(session_.wishCounts(), (WishCounts{1, 0, 0, 0}));
}

TEST_F(SessionTest, sendsAChangeOfPriorityOnlyIfItIsLarge) {
  open();
  const BlobRef blob = blobRef(5, 100);
  wishFor(blob);
  session_.setWishes(std::vector<Wish>{{blob, {}, proto::WishClass::kVisible, 11}});
  EXPECT_TRUE(changesOf(session_.takeOutgoing()).empty());
  session_.setWishes(std::vector<Wish>{{blob, {}, proto::WishClass::kVisible, 20}});
  const auto changes = changesOf(session_.takeOutgoing());
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].action, proto::WishAction::kReprioritise);
  EXPECT_EQ(changes[0].priority_px, 20);
}

TEST_F(SessionTest, cancelsWhatIsNoLongerWantedAndEndsItOnce) {
  open();
  const BlobRef blob = blobRef(5, 100);
  const uint32_t wish = wishFor(blob);
  session_.setWishes({});
  const auto changes = changesOf(session_.takeOutgoing());
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].action, proto::WishAction::kCancel);
  session_.setWishes({});
  EXPECT_TRUE(changesOf(session_.takeOutgoing()).empty());
  give(proto::encode(proto::Cancelled{wish}, 0));
  EXPECT_EQ(session_.openWishes(), 0u);
  EXPECT_EQ(session_.wishedBytes(), 0u);
  expectRefused(proto::encode(proto::Cancelled{wish}, 0), "cancelled");
}

TEST_F(SessionTest, takesABlobThatCompletesWhileItIsCancelled) {
  open();
  const uint32_t wish = wishFor(blobRef(5, 100));
  session_.setWishes({});
  EXPECT_EQ(give(blobFrames(wish, 5, 100)).size(), 1u);
  EXPECT_EQ(session_.openWishes(), 0u);
}

TEST_F(SessionTest, wishesAgainOnlyAfterACancelledWishHasEnded) {
  open();
  const BlobRef blob = blobRef(5, 100);
  const uint32_t wish = wishFor(blob);
  session_.setWishes({});
  session_.takeOutgoing();
  EXPECT_EQ(wishFor(blob), 0u);
  give(proto::encode(proto::Cancelled{wish}, 0));
  EXPECT_NE(wishFor(blob), 0u);
}

TEST_F(SessionTest, saysNothingMoreOfAWishThatItHasTakenBackHoweverMuchItIsWantedAgain) {
  open();
  const BlobRef blob = blobRef(5, 100);
  wishFor(blob);
  session_.setWishes({});
  session_.takeOutgoing();
  session_.setWishes(std::vector<Wish>{{blob, {}, proto::WishClass::kMargin, 1000}});
  EXPECT_TRUE(changesOf(session_.takeOutgoing()).empty());
}

TEST_F(SessionTest, reportsAWishThatTheServerRefuses) {
  open();
  const BlobRef blob = blobRef(5, 100);
  const uint32_t wish = wishFor(blob);
  const auto events =
      give(proto::encode(proto::ErrorMessage{proto::WireError::kDamagedStore, wish, false, "damaged"}, 0));
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(std::get<BlobRefused>(events[0]).blob, blob);
  EXPECT_EQ(session_.openWishes(), 0u);
}

TEST_F(SessionTest, tellsWhatIsLostFromWhatIsRefusedForNow) {
  open();
  const BlobRef blob = blobRef(5, 100);
  const std::pair<proto::WireError, bool> errors[] = {{proto::WireError::kDamagedStore, true},
                                                      {proto::WireError::kNoSuchBlob, true},
                                                      {proto::WireError::kNotReady, false},
                                                      {proto::WireError::kInternal, false}};
  for (const auto& [code, is_lost] : errors) {
    const auto events = give(proto::encode(proto::ErrorMessage{code, wishFor(blob), false, "no"}, 0));
    ASSERT_EQ(events.size(), 1u);
    EXPECT_EQ(std::get<BlobRefused>(events[0]).is_lost, is_lost) << static_cast<int>(code);
  }
}

TEST_F(SessionTest, keepsWishesWithinItsLimitOfBytes) {
  SessionOptions options = optionsFor("model");
  options.max_wished_bytes = 1000;
  Session session(options, kStart);
  session.receive(welcome() + opened(), kStart);
  while (session.nextEvent()) {
  }
  std::vector<Wish> wishes;
  for (uint32_t i = 0; i < 10; ++i)
    wishes.push_back({blobRef(10 + i, 400), {}, proto::WishClass::kVisible, 1});
  session.setWishes(wishes);
  EXPECT_EQ(session.openWishes(), 2u);
  EXPECT_LE(session.wishedBytes(), 1000u);
}

TEST_F(SessionTest, doesNotCountWishesThatItHasTakenBackInItsLimits) {
  SessionOptions options = optionsFor("model");
  options.max_wished_bytes = 1000;
  Session session(options, kStart);
  session.receive(welcome() + opened(), kStart);
  while (session.nextEvent()) {
  }
  session.setWishes(std::vector<Wish>{{blobRef(10, 1000)}});
  session.takeOutgoing();
  session.setWishes(std::vector<Wish>{{blobRef(11, 1000)}});
  const auto changes = changesOf(session.takeOutgoing());
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].action, proto::WishAction::kCancel);
  EXPECT_EQ(changes[1].action, proto::WishAction::kAdd);
}

TEST_F(SessionTest, wishesForABlobLargerThanTheLimitAlone) {
  SessionOptions options = optionsFor("model");
  options.max_wished_bytes = 1000;
  Session session(options, kStart);
  session.receive(welcome() + opened(), kStart);
  while (session.nextEvent()) {
  }
  session.setWishes(std::vector<Wish>{{blobRef(10, 4000)}, {blobRef(11, 10)}});
  EXPECT_EQ(session.openWishes(), 1u);
}

TEST_F(SessionTest, keepsWishesWithinTheNumberThatTheServerAllows) {
  Session session(optionsFor("model"), kStart);
  session.receive(proto::encode(proto::Welcome{proto::kProtocolVersion, 0, 3, "test"}, 1) + opened(), kStart);
  while (session.nextEvent()) {
  }
  std::vector<Wish> wishes;
  for (uint32_t i = 0; i < 10; ++i) wishes.push_back({blobRef(10 + i, 4), {}, proto::WishClass::kVisible, 1});
  session.setWishes(wishes);
  EXPECT_EQ(session.openWishes(), 3u);
}

TEST_F(SessionTest, keepsTheServerAWindowAhead) {
  open();
  constexpr size_t kSize = 3u << 20;
  const uint32_t wish = wishFor(blobRef(5, kSize));
  const Bytes frames = blobFrames(wish, 5, kSize);
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
  EXPECT_EQ(session_.openWishes(), 0u);
}

TEST_F(SessionTest, grantsMoreBeforeAChunkHasComeToItsEnd) {
  open();
  const uint32_t wish = wishFor(blobRef(5, proto::kMaxChunkBytes));
  const Bytes frame = blobFrames(wish, 5, proto::kMaxChunkBytes);
  give({frame.begin(), frame.begin() + frame.size() / 2});
  const auto credits = messagesOf<proto::Credit>(session_.takeOutgoing(), FrameType::kCredit);
  ASSERT_EQ(credits.size(), 1u);
  EXPECT_GE(credits[0].granted_bytes, proto::kInitialWindowBytes + frame.size() / 2);
}

/// On a clock of the test: half a second in which a link brings so many bytes a millisecond.
TEST_F(SessionTest, grantsAsMuchAsTheLinkThatItMeasuresCanHold) {
  open();
  give(proto::encode(proto::Pong{1}, 0), kStart + std::chrono::milliseconds(100));
  constexpr size_t kSize = 16u << 20;
  const uint32_t wish = wishFor(blobRef(5, kSize));
  const Bytes frames = blobFrames(wish, 5, kSize);
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

TEST_F(SessionTest, takesWishesOfALowerClassBackForThoseThatItHasNoRoomForOtherwise) {
  Session session(optionsFor("model"), kStart);
  session.receive(proto::encode(proto::Welcome{proto::kProtocolVersion, 0, 3, "test"}, 1) + opened(), kStart);
  while (session.nextEvent()) {
  }
  std::vector<Wish> wishes;
  for (uint32_t i = 0; i < 3; ++i) wishes.push_back({blobRef(10 + i, 4), {}, proto::WishClass::kPrefetch, 1});
  session.setWishes(wishes);
  session.takeOutgoing();
  wishes.insert(wishes.begin(), {blobRef(20, 4), {}, proto::WishClass::kVisible, 1});
  session.setWishes(wishes);
  const auto changes = changesOf(session.takeOutgoing());
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].action, proto::WishAction::kCancel);
  EXPECT_EQ(changes[1].action, proto::WishAction::kAdd);
  EXPECT_EQ(changes[1].blob, 20u);
}

}  // namespace
}  // namespace lode::core
