#include "server/serve/session/session.h"

#include <gtest/gtest.h>

#include "tests/unit/serve/session_fixture.h"

namespace lode::serve {
namespace {

using namespace test;

TEST_F(SessionTest, welcomesAVersionThatBothSpeak) {
  send(proto::Hello{1, 7, 0, "", "test"}, 3);
  const auto welcome = only<proto::Welcome>(FrameType::kWelcome, 3);
  EXPECT_EQ(welcome.version, proto::kProtocolVersion);
  EXPECT_EQ(welcome.max_open_requests, limits_.max_open_requests);
}

TEST_F(SessionTest, refusesAClientThatIsTooNew) {
  send(proto::Hello{proto::kProtocolVersion + 1, proto::kProtocolVersion + 3, 0, "", "test"});
  expectClosedWith(WireError::kVersion);
}

TEST_F(SessionTest, refusesAClientThatIsTooOld) {
  send(proto::Hello{3, 3, 0, "", "test"});
  const auto error = only<proto::ErrorMessage>(FrameType::kError);
  EXPECT_EQ(error.code, WireError::kVersion);
  EXPECT_EQ(error.message,
            "this server speaks version 4 of the protocol, the client none above 3; update the client");
  EXPECT_TRUE(session_.finished());
}

TEST_F(SessionTest, refusesAnyFrameBeforeHello) {
  send(proto::List{});
  expectClosedWith(WireError::kMalformed);
}

TEST_F(SessionTest, refusesASecondHello) {
  send(proto::Hello{});
  control();
  send(proto::Hello{});
  expectClosedWith(WireError::kMalformed);
}

TEST_F(SessionTest, listsTheModelsInOrder) {
  send(proto::Hello{});
  control();
  send(proto::List{}, 8);
  const auto list = only<proto::Models>(FrameType::kModels, 8);
  ASSERT_EQ(list.models.size(), 2u);
  EXPECT_EQ(list.models[0], modelAt(0).summary);
  EXPECT_EQ(list.models[1], modelAt(1).summary);
}

TEST_F(SessionTest, openIsAnsweredAndFollowedByPageAndCoarsestLod) {
  send(proto::Hello{});
  send(proto::Open{"b", {}}, 5);
  EXPECT_FALSE(session_.beginChunk()) << "no chunk may overtake Opened";
  const auto frames = control();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[1].header.call, 5u);
  EXPECT_EQ(proto::decode<proto::Opened>(frames[1].body), (proto::Opened{1, modelAt(1).summary}));
  for (const uint32_t blob : {kPageBlob, kRootLodBlob}) {
    const auto chunk = session_.beginChunk();
    ASSERT_TRUE(chunk);
    EXPECT_EQ(chunk->blob, blob);
    EXPECT_EQ(chunk->opened->model->summary.name, "b");
    EXPECT_EQ(chunk->call, 5u);
    EXPECT_EQ(chunk->header, (proto::BlobChunkHeader{0, modelAt(1).blobBytes(blob), 0}));
    EXPECT_TRUE(session_.finishChunk());
  }
  EXPECT_FALSE(session_.beginChunk());
}

TEST_F(SessionTest, sendsNothingUnrequestedIfTheClientKnowsTheBuild) {
  send(proto::Hello{});
  control();
  send(proto::Open{"a", model("a").summary.build_id}, 2);
  EXPECT_EQ(only<proto::Opened>(FrameType::kOpened, 2).summary, model("a").summary);
  EXPECT_FALSE(session_.beginChunk());
  send(proto::Open{"a", model("a", 2).summary.build_id}, 3);
  control();
  EXPECT_TRUE(session_.beginChunk());
}

TEST_F(SessionTest, aRootWithoutTrianglesIsFollowedByItsPageAlone) {
  Model empty = model("a");
  empty.coarsest_blob = 0;
  served_.catalog = catalogOf({empty});
  Session session(host_, limits_, now_);
  sendTo(session, proto::Hello{});
  sendTo(session, proto::Open{"a", {}});
  session.takeControl();
  EXPECT_EQ(session.beginChunk()->blob, kPageBlob);
  session.finishChunk();
  EXPECT_FALSE(session.beginChunk());
}

TEST_F(SessionTest, anUnknownModelIsAnErrorThatDoesNotClose) {
  send(proto::Hello{});
  control();
  send(proto::Open{"c", {}}, 6);
  const auto error = only<proto::ErrorMessage>(FrameType::kError, 6);
  EXPECT_EQ(error.code, WireError::kNoSuchModel);
  EXPECT_FALSE(error.closes);
  EXPECT_FALSE(session_.closing());
}

TEST_F(SessionTest, opensNoMoreModelsThanTheLimit) {
  send(proto::Hello{});
  for (uint32_t i = 0; i < limits_.max_open_models; ++i) send(proto::Open{"a", {}});
  const auto opened = control();
  EXPECT_EQ(opened.back().header.type, static_cast<uint8_t>(FrameType::kOpened));
  send(proto::Open{"a", {}}, 9);
  EXPECT_EQ(only<proto::ErrorMessage>(FrameType::kError, 9).code, WireError::kLimit);
}

TEST_F(SessionTest, answersPingWithItsPayload) {
  send(proto::Hello{});
  control();
  send(proto::Ping{77}, 4);
  EXPECT_EQ(only<proto::Pong>(FrameType::kPong, 4).payload, 77u);
}

TEST_F(SessionTest, ignoresAnUnrequestedPong) {
  send(proto::Hello{});
  control();
  send(proto::Pong{77});
  EXPECT_TRUE(control().empty());
  EXPECT_FALSE(session_.closing());
}

TEST_F(SessionTest, endsOnceItsTokenHasExpired) {
  const std::chrono::sys_seconds expiry = std::chrono::sys_days(std::chrono::year(2200) / 1 / 31) + 12h;
  served_.tokens =
      std::make_shared<const TokenFile>(TokenFile::parse("some 2200-01-31T12:00:00Z *\nother never *\n"));
  Session other(host_, limits_, now_);
  sendTo(other, proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, 0, "other", "test"});
  send(proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, 0, "some", "test"});
  control();
  session_.checkExpiry(expiry - 1s);
  EXPECT_FALSE(session_.closing());
  session_.checkExpiry(expiry);
  expectClosedWith(WireError::kUnauthorized);
  other.checkExpiry(expiry);
  EXPECT_FALSE(other.closing());
}

TEST_F(SessionTest, skipsAnUnknownFrameThatIsOptional) {
  sendRaw(200, proto::kFlagOptional);
  EXPECT_TRUE(control().empty());
  EXPECT_FALSE(session_.closing());
}

TEST_F(SessionTest, namesAnUnknownFrameThatIsNotOptional) {
  sendRaw(200, 0);
  const auto error = only<proto::ErrorMessage>(FrameType::kError);
  EXPECT_EQ(error.code, WireError::kUnknownFrame);
  EXPECT_NE(error.message.find("200"), std::string::npos);
  EXPECT_TRUE(session_.closing());
}

TEST_F(SessionTest, refusesFramesThatAreForClients) {
  send(proto::Hello{});
  control();
  send(proto::Cancelled{1});
  expectClosedWith(WireError::kMalformed);
}

TEST_F(SessionTest, refusesAMalformedBodyByName) {
  send(proto::Hello{});
  control();
  sendRaw(static_cast<uint8_t>(FrameType::kRequests), 0, proto::Bytes(20));
  const auto error = only<proto::ErrorMessage>(FrameType::kError);
  EXPECT_EQ(error.code, WireError::kMalformed);
  EXPECT_NE(error.message.find("Requests"), std::string::npos);
  EXPECT_TRUE(session_.closing());
}

TEST_F(SessionTest, readsNothingAfterItsClosingError) {
  sendRaw(200, 0);
  control();
  send(proto::Hello{});
  EXPECT_TRUE(control().empty());
}

TEST_F(SessionTest, closesAConnectionThatSendsNoHello) {
  EXPECT_EQ(session_.deadline(), now_ + limits_.handshake);
  now_ += 5s;
  sendRaw(200, proto::kFlagOptional);
  EXPECT_EQ(session_.deadline(), now_ - 5s + limits_.handshake) << "frames before Hello win no time";
}

TEST_F(SessionTest, extendsTheIdleDeadlineOnEachFrame) {
  send(proto::Hello{});
  EXPECT_EQ(session_.deadline(), now_ + limits_.idle);
  now_ += 100s;
  send(proto::Ping{1});
  EXPECT_EQ(session_.deadline(), now_ + limits_.idle);
}

TEST_F(SessionTest, doesNotExtendTheIdleDeadlineOnAnUnknownFrame) {
  send(proto::Hello{});
  const auto deadline = session_.deadline();
  now_ += 100s;
  sendRaw(200, proto::kFlagOptional);
  EXPECT_EQ(session_.deadline(), deadline);
}

TEST_F(SessionTest, drainingSaysGoAwayAndLetsRequestsEnd) {
  open();
  request(RequestClass::kVisible, 1, 3, 1);
  session_.drain("stopping", now_);
  session_.drain("stopping", now_);
  const auto frames = control();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(proto::decode<proto::GoAway>(frames[0].body).reason, "stopping");
  EXPECT_EQ(frames[1].header.type, static_cast<uint8_t>(FrameType::kPing));
  send(proto::Pong{});
  EXPECT_FALSE(session_.finished());
  EXPECT_EQ(sendChunk(), 1u);
  EXPECT_TRUE(session_.finished());
}

TEST_F(SessionTest, answersRequestsThatCrossGoAway) {
  open();
  session_.drain("stopping", now_);
  control();
  EXPECT_FALSE(session_.finished()) << "a request may be under way";
  request(RequestClass::kVisible, 1, 3, 1);
  EXPECT_EQ(sendChunk(), 1u);
  EXPECT_FALSE(session_.finished()) << "another may be";
  send(proto::Pong{});
  EXPECT_TRUE(session_.finished());
}

TEST_F(SessionTest, drainsNoLongerThanItsDeadlineForASilentClient) {
  open();
  session_.drain("stopping", now_);
  EXPECT_FALSE(session_.stopWaitingForPong(now_ + proto::kHearDeadline - 1ms));
  EXPECT_FALSE(session_.finished());
  EXPECT_TRUE(session_.stopWaitingForPong(now_ + proto::kHearDeadline));
  EXPECT_TRUE(session_.finished());
}

TEST_F(SessionTest, drainingAnswersFramesAsBeforeUntilTheLastRequestHasEnded) {
  open();
  request(RequestClass::kVisible, 1, 3, 1);
  session_.drain("stopping", now_);
  control();
  send(proto::Pong{});
  send(proto::Open{"b", {}}, 9);
  EXPECT_EQ(only<proto::Opened>(FrameType::kOpened, 9).summary.name, "b");
  request(RequestClass::kVisible, 2, 4, 1);
  for (int chunk = 0; chunk < 3; ++chunk) EXPECT_TRUE(sendChunk());
  EXPECT_FALSE(session_.finished());
  EXPECT_EQ(sendChunk(), 2u);
  EXPECT_TRUE(session_.finished());
}

TEST_F(SessionTest, sendsGoAwayAndEndsIfDrainedBeforeHello) {
  session_.drain("stopping", now_);
  EXPECT_EQ(only<proto::GoAway>(FrameType::kGoAway).reason, "stopping");
  EXPECT_TRUE(session_.finished());
}

TEST_F(SessionTest, limitsTheAnswersToOneFrame) {
  open();
  proto::Requests requests{1, {}};
  for (uint32_t i = 1; i <= proto::kMaxRequestsPerFrame; ++i)
    requests.changes.push_back({RequestAction::kAdd, RequestClass::kVisible, i, 0xFFFFFFFF, 0});
  send(requests);
  EXPECT_GT(session_.controlBytes(), proto::kMaxQueuedAnswerBytes);
  EXPECT_LT(session_.controlBytes(), 512u << 10);
}

}  // namespace
}  // namespace lode::serve
