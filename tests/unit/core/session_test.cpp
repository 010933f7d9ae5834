#include "client/core/session.h"

#include <algorithm>
#include <variant>

#include <gtest/gtest.h>

#include "common/error.h"
#include "proto/limits.h"

namespace lode::core {
namespace {

using proto::Bytes;
using proto::FrameType;

constexpr TimePoint kStart{};

struct SentFrame {
  proto::FrameHeader header;
  Bytes body;
};

std::vector<SentFrame> framesOf(const Bytes& bytes) {
  std::vector<SentFrame> frames;
  std::span<const std::byte> rest = bytes;
  while (!rest.empty()) {
    const auto header = proto::decodeFrameHeader(rest.first<proto::kFrameHeaderBytes>());
    const auto body = rest.subspan(proto::kFrameHeaderBytes, header.body_bytes);
    frames.push_back({header, {body.begin(), body.end()}});
    rest = rest.subspan(proto::kFrameHeaderBytes + header.body_bytes);
  }
  return frames;
}

template <typename Message>
std::vector<Message> messagesOf(const Bytes& bytes, FrameType type) {
  std::vector<Message> messages;
  for (const SentFrame& frame : framesOf(bytes))
    if (frame.header.type == static_cast<uint8_t>(type))
      messages.push_back(proto::decode<Message>(frame.body));
  return messages;
}

std::vector<proto::WishChange> changesOf(const Bytes& bytes) {
  std::vector<proto::WishChange> changes;
  for (const auto& wishes : messagesOf<proto::Wishes>(bytes, FrameType::kWishes))
    changes.insert(changes.end(), wishes.changes.begin(), wishes.changes.end());
  return changes;
}

Bytes blobBytes(uint32_t number, size_t size) {
  Bytes bytes(size);
  for (size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(number * 31 + i * 7);
  return bytes;
}

BlobRef blobRef(uint32_t number, size_t size) {
  return {number, static_cast<uint32_t>(size), nameBlob(blobBytes(number, size))};
}

Bytes frameOf(FrameType type, uint8_t flags, std::span<const std::byte> body) {
  const auto header =
      proto::encodeFrameHeader({static_cast<uint32_t>(body.size()), static_cast<uint8_t>(type), flags, 0});
  Bytes frame(header.size() + body.size());
  std::copy(body.begin(), body.end(), std::copy(header.begin(), header.end(), frame.begin()));
  return frame;
}

Bytes chunkFrame(uint32_t wish, uint32_t total, uint32_t offset, std::span<const std::byte> bytes) {
  const auto fields = proto::encodeBlobChunkHeader({wish, total, offset});
  Bytes body(fields.size() + bytes.size());
  std::copy(bytes.begin(), bytes.end(), std::copy(fields.begin(), fields.end(), body.begin()));
  return frameOf(FrameType::kBlob, 0, body);
}

/// A whole blob in frames of at most 32 KB.
Bytes blobFrames(uint32_t wish, uint32_t number, size_t size) {
  const Bytes blob = blobBytes(number, size);
  Bytes frames;
  for (size_t offset = 0; offset < size; offset += proto::kMaxChunkBytes) {
    const auto chunk =
        std::span(blob).subspan(offset, std::min<size_t>(proto::kMaxChunkBytes, size - offset));
    const Bytes frame = chunkFrame(wish, static_cast<uint32_t>(size), static_cast<uint32_t>(offset), chunk);
    frames.insert(frames.end(), frame.begin(), frame.end());
  }
  return frames;
}

constexpr uint32_t kPageBlob = 1, kPageBytes = 300;

Bytes welcome() { return proto::encode(proto::Welcome{1, 0, 16384, "test"}, 1); }

Bytes opened() {
  proto::Opened message;
  message.handle = 7;
  message.summary.name = "model";
  message.summary.nodes = 9;
  message.summary.root_page = blobRef(kPageBlob, kPageBytes);
  return proto::encode(message, 2);
}

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

SessionOptions optionsFor(const std::string& model) {
  SessionOptions options;
  options.model = model;
  return options;
}

class SessionTest : public testing::Test {
 protected:
  std::vector<SessionEvent> give(const Bytes& bytes, TimePoint now = kStart) {
    session_.receive(bytes, now);
    std::vector<SessionEvent> events;
    while (auto event = session_.nextEvent()) events.push_back(std::move(*event));
    return events;
  }
  /// Up to an open model whose root page has come.
  void open() {
    give(welcome() + opened() + blobFrames(0, kPageBlob, kPageBytes));
    session_.takeOutgoing();
  }
  /// Wishes for one blob. @return the number of the wish.
  uint32_t wishFor(const BlobRef& blob) {
    session_.setWishes(std::vector<BlobWish>{{blob, proto::WishClass::kVisible, 10}});
    const auto changes = changesOf(session_.takeOutgoing());
    return changes.empty() ? 0 : changes.back().wish;
  }
  void expectRefused(const Bytes& bytes, const std::string& part_of_message) {
    try {
      give(bytes);
      FAIL() << "not refused";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(part_of_message), std::string::npos) << error.what();
    }
  }

  Session session_{optionsFor("model"), kStart};
};

TEST_F(SessionTest, sendsHelloAndOpenTogether) {
  const auto frames = framesOf(session_.takeOutgoing());
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].header.type, static_cast<uint8_t>(FrameType::kHello));
  EXPECT_EQ(frames[1].header.type, static_cast<uint8_t>(FrameType::kOpen));
  EXPECT_EQ(proto::decode<proto::Open>(frames[1].body).model, "model");
  EXPECT_TRUE(session_.takeOutgoing().empty());
}

TEST_F(SessionTest, opensAModelAndTakesTheRootPageUnasked) {
  const auto events = give(welcome() + opened() + blobFrames(0, kPageBlob, kPageBytes));
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(std::get<ModelOpened>(events[0]).summary.name, "model");
  EXPECT_EQ(std::get<BlobArrived>(events[1]).bytes, blobBytes(kPageBlob, kPageBytes));
  EXPECT_TRUE(session_.opened());
}

TEST_F(SessionTest, understandsBytesCutAnywhere) {
  const Bytes all = welcome() + opened() + blobFrames(0, kPageBlob, kPageBytes);
  std::vector<SessionEvent> events;
  for (const std::byte byte : all)
    for (SessionEvent& event : give({byte})) events.push_back(std::move(event));
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(std::get<BlobArrived>(events[1]).bytes, blobBytes(kPageBlob, kPageBytes));
  EXPECT_EQ(session_.receivedBytes(), all.size());
}

TEST_F(SessionTest, listsModels) {
  Session session(optionsFor(""), kStart);
  EXPECT_EQ(framesOf(session.takeOutgoing())[1].header.type, static_cast<uint8_t>(FrameType::kList));
  proto::Models models;
  models.models.resize(2);
  for (ModelSummary& model : models.models) {
    model.name = "m";
    model.root_page = blobRef(1, 10);
  }
  session.receive(welcome() + proto::encode(models, 2), kStart);
  const auto event = session.nextEvent();
  ASSERT_TRUE(event);
  EXPECT_EQ(std::get<ModelsListed>(*event).models.size(), 2u);
}

TEST_F(SessionTest, wishesOnceForABlobAndDeliversItsBytes) {
  open();
  const BlobRef blob = blobRef(5, 100'000);
  const uint32_t wish = wishFor(blob);
  EXPECT_NE(wish, 0u);
  EXPECT_EQ(wishFor(blob), 0u);
  const auto events = give(blobFrames(wish, 5, 100'000));
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(std::get<BlobArrived>(events[0]).blob, blob);
  EXPECT_EQ(std::get<BlobArrived>(events[0]).bytes, blobBytes(5, 100'000));
  EXPECT_EQ(session_.openWishes(), 0u);
  EXPECT_EQ(session_.wishedBytes(), 0u);
}

TEST_F(SessionTest, sendsAChangeOfPriorityOnlyIfItIsLarge) {
  open();
  const BlobRef blob = blobRef(5, 100);
  wishFor(blob);
  session_.setWishes(std::vector<BlobWish>{{blob, proto::WishClass::kVisible, 11}});
  EXPECT_TRUE(changesOf(session_.takeOutgoing()).empty());
  session_.setWishes(std::vector<BlobWish>{{blob, proto::WishClass::kVisible, 20}});
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

TEST_F(SessionTest, keepsWishesWithinItsLimitOfBytes) {
  SessionOptions options = optionsFor("model");
  options.max_wished_bytes = 1000;
  Session session(options, kStart);
  session.receive(welcome() + opened(), kStart);
  while (session.nextEvent()) {
  }
  std::vector<BlobWish> wishes;
  for (uint32_t i = 0; i < 10; ++i) wishes.push_back({blobRef(10 + i, 400), proto::WishClass::kVisible, 1});
  session.setWishes(wishes);
  EXPECT_EQ(session.openWishes(), 2u);
  EXPECT_LE(session.wishedBytes(), 1000u);
}

TEST_F(SessionTest, wishesForABlobLargerThanTheLimitAlone) {
  SessionOptions options = optionsFor("model");
  options.max_wished_bytes = 1000;
  Session session(options, kStart);
  session.receive(welcome() + opened(), kStart);
  while (session.nextEvent()) {
  }
  session.setWishes(std::vector<BlobWish>{{blobRef(10, 4000)}, {blobRef(11, 10)}});
  EXPECT_EQ(session.openWishes(), 1u);
}

TEST_F(SessionTest, keepsWishesWithinTheNumberThatTheServerAllows) {
  Session session(optionsFor("model"), kStart);
  session.receive(proto::encode(proto::Welcome{1, 0, 3, "test"}, 1) + opened(), kStart);
  while (session.nextEvent()) {
  }
  std::vector<BlobWish> wishes;
  for (uint32_t i = 0; i < 10; ++i) wishes.push_back({blobRef(10 + i, 4), proto::WishClass::kVisible, 1});
  session.setWishes(wishes);
  EXPECT_EQ(session.openWishes(), 3u);
}

TEST_F(SessionTest, keepsTheServerAWindowAhead) {
  give(welcome());
  auto credits = messagesOf<proto::Credit>(session_.takeOutgoing(), FrameType::kCredit);
  ASSERT_EQ(credits.size(), 1u);
  EXPECT_EQ(credits[0].granted_bytes, proto::kFixedWindowBytes);
  give(opened() + blobFrames(0, kPageBlob, kPageBytes));
  constexpr size_t kSize = 3u << 20;
  const uint32_t wish = wishFor(blobRef(5, kSize));
  const Bytes frames = blobFrames(wish, 5, kSize);
  uint64_t sent = kPageBytes + proto::kBlobChunkHeaderBytes, granted = proto::kFixedWindowBytes;
  for (const SentFrame& frame : framesOf(frames)) {
    sent += frame.body.size();
    ASSERT_LE(sent, granted);
    give(frameOf(FrameType::kBlob, 0, frame.body));
    for (const auto& credit : messagesOf<proto::Credit>(session_.takeOutgoing(), FrameType::kCredit)) {
      EXPECT_GT(credit.granted_bytes, granted);
      granted = credit.granted_bytes;
      EXPECT_EQ(granted, sent + proto::kFixedWindowBytes);
    }
  }
  EXPECT_EQ(session_.openWishes(), 0u);
}

TEST_F(SessionTest, refusesMoreBytesThanTheServerCanHaveBeenGranted) {
  open();
  constexpr size_t kSize = proto::kFixedWindowBytes + proto::kMaxChunkBytes;
  const uint32_t wish = wishFor(blobRef(5, kSize));
  expectRefused(blobFrames(wish, 5, kSize), "credit");
}

TEST_F(SessionTest, refusesMoreThanTheFirstWindowBeforeACreditWasSent) {
  session_.takeOutgoing();
  give(welcome() + opened() + blobFrames(0, kPageBlob, kPageBytes));
  session_.expectUnasked(blobRef(5, proto::kInitialWindowBytes));
  expectRefused(blobFrames(0, 5, proto::kInitialWindowBytes), "credit");
}

TEST_F(SessionTest, refusesAnAnswerOutOfTurn) { expectRefused(opened(), "out of turn"); }

TEST_F(SessionTest, refusesASecondWelcome) {
  give(welcome());
  expectRefused(welcome(), "out of turn");
}

TEST_F(SessionTest, refusesAnAnswerToAnotherRequest) {
  expectRefused(proto::encode(proto::Welcome{1, 0, 16, ""}, 9), "out of turn");
}

TEST_F(SessionTest, refusesAVersionThatItDidNotOffer) {
  expectRefused(proto::encode(proto::Welcome{2, 0, 16, ""}, 1), "version 2");
}

TEST_F(SessionTest, refusesAServerWithoutWishes) {
  expectRefused(proto::encode(proto::Welcome{1, 0, 0, ""}, 1), "no wishes");
}

TEST_F(SessionTest, refusesABlobThatWasNotWishedFor) {
  open();
  expectRefused(blobFrames(99, 5, 100), "not wished for");
}

TEST_F(SessionTest, refusesAnUnaskedBlobBeyondTheAnnouncedOnes) {
  open();
  expectRefused(blobFrames(0, 5, 100), "not wished for");
}

TEST_F(SessionTest, takesTheSecondUnaskedBlobOnceItIsNamed) {
  open();
  session_.expectUnasked(blobRef(5, 100));
  EXPECT_EQ(wishFor(blobRef(5, 100)), 0u);
  EXPECT_EQ(give(blobFrames(0, 5, 100)).size(), 1u);
}

TEST_F(SessionTest, refusesABlobOfAnotherSize) {
  open();
  const uint32_t wish = wishFor(blobRef(5, 100));
  expectRefused(blobFrames(wish, 5, 101), "another size");
}

TEST_F(SessionTest, refusesAChunkOutOfOrder) {
  open();
  const uint32_t wish = wishFor(blobRef(5, 100));
  expectRefused(chunkFrame(wish, 100, 50, blobBytes(5, 50)), "out of order");
}

TEST_F(SessionTest, refusesAChunkThatOverlapsTheOneBefore) {
  open();
  const uint32_t wish = wishFor(blobRef(5, 100));
  give(chunkFrame(wish, 100, 0, blobBytes(5, 60)));
  expectRefused(chunkFrame(wish, 100, 50, blobBytes(5, 50)), "out of order");
}

TEST_F(SessionTest, refusesAChunkBeyondTheEndOfItsBlob) {
  open();
  const uint32_t wish = wishFor(blobRef(5, 100));
  give(chunkFrame(wish, 100, 0, blobBytes(5, 60)));
  expectRefused(chunkFrame(wish, 100, 60, blobBytes(5, 41)), "beyond");
}

TEST_F(SessionTest, refusesABlobWhoseBytesAreNotWhatItsNameSays) {
  open();
  const uint32_t wish = wishFor(blobRef(5, 100));
  expectRefused(blobFrames(wish, 6, 100), "name");
}

TEST_F(SessionTest, refusesAnErrorForAWishThatIsNotOpen) {
  open();
  expectRefused(proto::encode(proto::ErrorMessage{proto::WireError::kInternal, 44, false, "x"}, 0),
                "not open");
}

TEST_F(SessionTest, refusesACancellationThatWasNotAskedFor) {
  open();
  const uint32_t wish = wishFor(blobRef(5, 100));
  expectRefused(proto::encode(proto::Cancelled{wish}, 0), "cancelled");
}

TEST_F(SessionTest, refusesAPongWithoutAPing) {
  give(welcome());
  expectRefused(proto::encode(proto::Pong{5}, 0), "Pong");
}

TEST_F(SessionTest, refusesAFrameThatIsNotForAClient) {
  expectRefused(proto::encode(proto::Hello{}, 1), "not for a client");
}

TEST_F(SessionTest, skipsAnUnknownFrameThatIsOptional) {
  const Bytes unknown = frameOf(static_cast<FrameType>(77), proto::kFlagOptional, blobBytes(1, 20));
  EXPECT_EQ(give(unknown + welcome() + opened()).size(), 1u);
}

TEST_F(SessionTest, refusesAnUnknownFrameThatIsNotOptional) {
  expectRefused(frameOf(static_cast<FrameType>(77), 0, blobBytes(1, 20)), "77");
}

TEST_F(SessionTest, refusesAFrameLongerThanTheLimitBeforeItsBodyHasCome) {
  const auto header = proto::encodeFrameHeader({proto::kMaxFrameBodyBytes + 1, 2, 0, 0});
  expectRefused({header.begin(), header.end()}, "limit");
}

TEST_F(SessionTest, refusesEveryTruncatedBody) {
  const Bytes whole = welcome();
  for (size_t size = 0; size + proto::kFrameHeaderBytes < whole.size(); size += 4) {
    Session session(optionsFor("model"), kStart);
    const Bytes body(whole.begin() + proto::kFrameHeaderBytes,
                     whole.begin() + static_cast<ptrdiff_t>(proto::kFrameHeaderBytes + size));
    session.receive(frameOf(FrameType::kWelcome, 0, body), kStart);
    EXPECT_THROW(session.nextEvent(), Error) << size;
  }
}

TEST_F(SessionTest, saysWhatTheServerSaysWhenThereIsNoSuchModel) {
  give(welcome());
  expectRefused(proto::encode(proto::ErrorMessage{proto::WireError::kNoSuchModel, 0, false, "no model x"}, 2),
                "no model x; lodestream list");
}

TEST_F(SessionTest, saysThatTheServerIsLeaving) {
  open();
  const auto events = give(proto::encode(proto::GoAway{"drain"}, 0));
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(std::get<ServerLeaving>(events[0]).reason, "drain");
}

TEST_F(SessionTest, pingsASilentServerAndMeasuresTheRoundTrip) {
  open();
  give(proto::encode(proto::Pong{1}, 0), kStart + std::chrono::milliseconds(70));
  EXPECT_EQ(session_.roundTrip(), std::chrono::milliseconds(70));
  session_.tick(kStart + std::chrono::seconds(9));
  EXPECT_TRUE(session_.takeOutgoing().empty());
  const TimePoint late = kStart + std::chrono::seconds(11);
  session_.tick(late);
  const auto pings = messagesOf<proto::Ping>(session_.takeOutgoing(), FrameType::kPing);
  ASSERT_EQ(pings.size(), 1u);
  give(proto::encode(proto::Pong{pings[0].payload}, 0), late + std::chrono::milliseconds(50));
  EXPECT_EQ(session_.roundTrip(), std::chrono::milliseconds(50));
}

TEST_F(SessionTest, givesUpOnAServerThatSaysNothing) {
  open();
  EXPECT_NO_THROW(session_.tick(kStart + kSilenceLimit - std::chrono::seconds(1)));
  EXPECT_THROW(session_.tick(kStart + kSilenceLimit), Error);
}

}  // namespace
}  // namespace lode::core
