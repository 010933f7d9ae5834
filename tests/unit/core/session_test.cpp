#include "client/core/session/session.h"

#include <gtest/gtest.h>

#include "tests/unit/core/session_fixture.h"

namespace lode::core {
namespace {

using namespace fixture;

TEST_F(SessionTest, sendsHelloAndOpenTogether) {
  const auto frames = framesOf(session_.takeOutgoing());
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].header.type, static_cast<uint8_t>(FrameType::kHello));
  EXPECT_EQ(frames[1].header.type, static_cast<uint8_t>(FrameType::kOpen));
  EXPECT_EQ(proto::decode<proto::Open>(frames[1].body).model, "model");
  EXPECT_TRUE(session_.takeOutgoing().empty());
}

TEST_F(SessionTest, opensAModelAndReceivesTheRootPageUnrequested) {
  const auto events = give(welcome() + opened() + blobFrames(0, kPageBlob, kPageBytes));
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(std::get<ModelOpened>(events[0]).summary.name, "model");
  EXPECT_EQ(std::get<BlobArrived>(events[1]).bytes, blobBytes(kPageBlob, kPageBytes));
  EXPECT_TRUE(session_.opened());
}

TEST_F(SessionTest, readsFramesSplitAnywhere) {
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

TEST_F(SessionTest, receivesTheSecondUnrequestedBlobOnceItIsNamed) {
  open();
  session_.expectUnasked(blobRef(5, 100), {});
  EXPECT_EQ(makeRequest(blobRef(5, 100)), 0u);
  EXPECT_EQ(give(blobFrames(0, 5, 100)).size(), 1u);
}

TEST_F(SessionTest, skipsAnUnknownFrameThatIsOptional) {
  const Bytes unknown = frameOf(static_cast<FrameType>(77), proto::kFlagOptional, blobBytes(1, 20));
  EXPECT_EQ(give(unknown + welcome() + opened()).size(), 1u);
}

TEST_F(SessionTest, saysThatAnotherProgramAnswers) {
  const std::string_view web = "<!DOCTYPE HTML>\n<html lang=\"en\">\n";
  expectRefused(Bytes(std::as_bytes(std::span(web)).begin(), std::as_bytes(std::span(web)).end()),
                "is not lodestreamd; check the port");
}

TEST_F(SessionTest, quotesTheServerIfTheModelIsUnknown) {
  give(welcome());
  expectRefused(proto::encode(proto::ErrorMessage{proto::WireError::kNoSuchModel, 0, false, "no model x"}, 2),
                "the server says: no model x", Remedy::kModel);
}

TEST_F(SessionTest, leavesTheWordsForATokenToTheProgram) {
  expectRefused(proto::encode(proto::ErrorMessage{proto::WireError::kUnauthorized, 0, true, "no token"}, 1),
                "the server says: no token", Remedy::kToken);
}

TEST_F(SessionTest, treatsAServerWithoutAnAwaitedModelAsLeaving) {
  SessionOptions options;
  options.model = "bunny";
  options.awaits_model = true;
  session_ = Session(options, kStart);
  give(welcome());
  const auto events =
      give(proto::encode(proto::ErrorMessage{proto::WireError::kNoSuchModel, 0, false, "no model x"}, 2));
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(std::get<ServerLeaving>(events[0]).reason, "the server says: no model x");
  EXPECT_EQ(std::get<ServerLeaving>(events[0]).remedy, Remedy::kModel);
}

TEST_F(SessionTest, saysThatTheServerIsTooOld) {
  const std::string why =
      "this server speaks version 3 of the protocol, the client 4 or newer; update the server";
  expectRefused(proto::encode(proto::ErrorMessage{proto::WireError::kVersion, 0, true, why}, 1),
                "the server says: " + why);
}

TEST_F(SessionTest, saysThatTheServerIsLeaving) {
  open();
  const auto events = give(proto::encode(proto::GoAway{"drain"}, 0));
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(std::get<ServerLeaving>(events[0]).reason,
            "the server is shutting down (drain); try again later");
}

TEST_F(SessionTest, treatsAnInternalServerErrorAsTemporary) {
  try {
    give(proto::encode(proto::ErrorMessage{proto::WireError::kInternal, 0, true, "no threads"}, 0));
    FAIL() << "not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kNetwork) << error.what();
    EXPECT_NE(std::string(error.what()).find("no threads"), std::string::npos) << error.what();
  }
}

TEST_F(SessionTest, answersPingWithItsPayload) {
  open();
  give(proto::encode(proto::Ping{77}, 0));
  const auto pongs = messagesOf<proto::Pong>(session_.takeOutgoing(), FrameType::kPong);
  ASSERT_EQ(pongs.size(), 1u);
  EXPECT_EQ(pongs[0].payload, 77u);
}

TEST_F(SessionTest, pingsASilentServerAndMeasuresTheRoundTrip) {
  open();
  give(proto::encode(proto::Pong{1}, 0), kStart + std::chrono::milliseconds(70));
  EXPECT_EQ(session_.window().roundTrip(), std::chrono::milliseconds(70));
  listen(kStart, 9);
  EXPECT_TRUE(session_.takeOutgoing().empty());
  const TimePoint late = listen(kStart + std::chrono::seconds(9), 2);
  const auto pings = messagesOf<proto::Ping>(session_.takeOutgoing(), FrameType::kPing);
  ASSERT_EQ(pings.size(), 1u);
  give(proto::encode(proto::Pong{pings[0].payload}, 0), late + std::chrono::milliseconds(50));
  EXPECT_EQ(session_.window().roundTrip(), std::chrono::milliseconds(50));
}

TEST_F(SessionTest, measuresTheRoundTripEachSecondWhileBlobsAreAwaited) {
  open();
  give(proto::encode(proto::Pong{1}, 0), kStart + std::chrono::milliseconds(70));
  const uint32_t request = makeRequest(blobRef(5, 100));
  TimePoint now = kStart;
  for (uint64_t second = 1; second <= 5; ++second) {
    session_.tick(now += std::chrono::seconds(1));
    const auto pings = messagesOf<proto::Ping>(session_.takeOutgoing(), FrameType::kPing);
    ASSERT_EQ(pings.size(), 1u) << second;
    give(proto::encode(proto::Pong{pings[0].payload}, 0), now + std::chrono::milliseconds(60));
  }
  EXPECT_EQ(session_.window().roundTrip(), std::chrono::milliseconds(60));
  give(blobFrames(request, 5, 100), now);
  session_.tick(now + std::chrono::seconds(2));
  EXPECT_TRUE(messagesOf<proto::Ping>(session_.takeOutgoing(), FrameType::kPing).empty());
}

TEST_F(SessionTest, givesUpOnASilentServer) {
  open();
  const TimePoint last = listen(kStart, 29);
  EXPECT_THROW(session_.tick(last + std::chrono::seconds(1)), Error);
}

TEST_F(SessionTest, doesNotMistakeAPauseOfItsCallerForASilentServer) {
  open();
  EXPECT_NO_THROW(session_.tick(kStart + std::chrono::minutes(5)));
  EXPECT_NO_THROW(session_.tick(kStart + std::chrono::minutes(6)));
}

TEST_F(SessionTest, sendsSomethingDuringALongTransfer) {
  open();
  const uint32_t request = makeRequest(blobRef(5, 100));
  const Bytes blob = blobBytes(5, 100);
  int heard = 0;
  for (uint32_t second = 0; second < 60; ++second) {
    give(chunkFrame(request, 100, second, std::span(blob).subspan(second, 1)),
         kStart + std::chrono::seconds(second));
    session_.tick(kStart + std::chrono::seconds(second));
    heard += session_.takeOutgoing().empty() ? 0 : 1;
  }
  EXPECT_GE(heard, 5);
}

TEST_F(SessionTest, reportsAFullServerAsTemporary) {
  const auto events = give(proto::encode(proto::ErrorMessage{proto::WireError::kLimit, 0, true, "full"}, 0));
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(std::get<ServerLeaving>(events[0]).reason, "the server says: full");
}

}  // namespace
}  // namespace lode::core
