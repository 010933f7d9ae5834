#include <gtest/gtest.h>

#include "server/serve/session/session.h"
#include "tests/unit/serve/session_fixture.h"

namespace lode::serve {
namespace {

using namespace test;

using SessionHandlesTest = SessionTest;

TEST_F(SessionHandlesTest, confirmsTheCloseFeatureIfAClientOffersIt) {
  send(
      proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, proto::kFeatureClose | 1u << 5, "", ""});
  EXPECT_EQ(only<proto::Welcome>(FrameType::kWelcome).features, proto::kFeatureClose);
}

TEST_F(SessionHandlesTest, closingEndsTheRequestsOfThatHandleAlone) {
  open();
  send(proto::Open{"b", {}});
  session_.takeControl();
  request(RequestClass::kVisible, 1, 30, 1, 11);
  send(proto::Requests{2, {{RequestAction::kAdd, RequestClass::kVisible, 2, 31, 9}}}, 12);
  send(proto::Close{2}, 13);
  const auto frames = control();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].header.call, 12u);
  EXPECT_EQ(proto::decode<proto::Cancelled>(frames[0].body).request, 2u);
  EXPECT_EQ(frames[1].header.call, 13u);
  EXPECT_EQ(proto::decode<proto::Closed>(frames[1].body).handle, 2u);
  EXPECT_EQ(sendChunk(), 1u) << "the unasked blobs of the closed one do not come either";
}

TEST_F(SessionHandlesTest, aChunkOfAClosedHandleIsNotSent) {
  open();
  request(RequestClass::kVisible, 1, 30, 1);
  ASSERT_TRUE(session_.beginChunk());
  send(proto::Close{1});
  EXPECT_FALSE(session_.finishChunk());
}

TEST_F(SessionHandlesTest, sendsNoUnrequestedChunkOfAClosedHandle) {
  send(proto::Hello{});
  send(proto::Open{"a", {}}, 1);
  send(proto::Open{"b", {}}, 2);
  session_.takeControl();
  ASSERT_EQ(session_.beginChunk()->call, 1u);
  send(proto::Close{1}, 3);
  session_.takeControl();
  EXPECT_FALSE(session_.finishChunk());
  const auto next = session_.beginChunk();
  ASSERT_TRUE(next);
  EXPECT_EQ(next->call, 2u);
  EXPECT_EQ(next->blob, kPageBlob);
  EXPECT_TRUE(next->first());
}

TEST_F(SessionHandlesTest, neverReusesAClosedHandle) {
  open();
  send(proto::Close{1});
  control();
  send(proto::Open{"a", {}}, 5);
  EXPECT_EQ(only<proto::Opened>(FrameType::kOpened, 5).handle, 2u);
  send(proto::Requests{1, {}});
  expectClosedWith(WireError::kMalformed);
}

TEST_F(SessionHandlesTest, closesTheConnectionOnCloseOfAnUnknownHandle) {
  open();
  send(proto::Close{9});
  expectClosedWith(WireError::kMalformed);
}

TEST_F(SessionHandlesTest, opensModelsWithoutLimitIfTheyAreClosed) {
  send(proto::Hello{});
  for (uint32_t i = 1; i <= 10 * proto::kMaxOpenModels; ++i) {
    send(proto::Open{"a", {}});
    send(proto::Close{i});
    const auto frames = control();
    ASSERT_TRUE(frames.back().header.type == static_cast<uint8_t>(FrameType::kClosed)) << i;
  }
}

TEST_F(SessionHandlesTest, announcesAReplacedModelOncePerHandleAndKeepsServingIt) {
  open();
  send(proto::Open{"b", {}});
  control();
  served_.catalog = catalogOf({model("a", 2), model("b")});
  session_.servedSetChanged();
  EXPECT_EQ(only<proto::ModelReplaced>(FrameType::kModelReplaced).handle, 1u);
  session_.servedSetChanged();
  EXPECT_TRUE(control().empty());
  request(RequestClass::kVisible, 1, 3, 1);
  send(proto::Open{"a", {}}, 4);
  EXPECT_EQ(only<proto::Opened>(FrameType::kOpened, 4).summary.build_id, modelAt(0).summary.build_id);
}

TEST_F(SessionHandlesTest, keepsServingARemovedModelButDoesNotOpenIt) {
  open();
  served_.catalog = catalogOf({model("b")});
  session_.servedSetChanged();
  EXPECT_TRUE(control().empty());
  request(RequestClass::kVisible, 1, 3, 1);
  EXPECT_EQ(sendChunk(), 1u);
  send(proto::Open{"a", {}}, 4);
  EXPECT_EQ(only<proto::ErrorMessage>(FrameType::kError, 4).code, WireError::kNoSuchModel);
}

TEST_F(SessionHandlesTest, passesOverAParkedRequestUntilItsBytesArrive) {
  open();
  send(proto::Credit{1 << 30});
  request(RequestClass::kVisible, 1, 30, 9);
  request(RequestClass::kVisible, 2, 3, 1);
  const auto cold = session_.beginChunk();
  ASSERT_TRUE(cold);
  session_.parkChunk();
  EXPECT_EQ(sendChunk(), 2u);
  EXPECT_FALSE(session_.beginChunk());
  EXPECT_TRUE(session_.unpark(*cold));
  EXPECT_EQ(session_.beginChunk()->header, cold->header);
}

TEST_F(SessionHandlesTest, distinguishesACancelledParkedRequestFromALaterOne) {
  open();
  request(RequestClass::kVisible, 1, 3, 9);
  const auto cold = session_.beginChunk();
  session_.parkChunk();
  change(RequestAction::kCancel, RequestClass::kVisible, 1);
  EXPECT_EQ(only<proto::Cancelled>(FrameType::kCancelled).request, 1u) << "at once, disk or not";
  request(RequestClass::kVisible, 1, 4, 9);
  EXPECT_FALSE(session_.unpark(*cold));
  EXPECT_EQ(session_.beginChunk()->blob, 4u);
}

TEST_F(SessionHandlesTest, keepsAParkedRequestParkedOnANewPriority) {
  open();
  request(RequestClass::kVisible, 1, 3, 1);
  const auto cold = session_.beginChunk();
  session_.parkChunk();
  change(RequestAction::kReprioritise, RequestClass::kVisible, 1, 50);
  EXPECT_FALSE(session_.beginChunk());
  request(RequestClass::kVisible, 2, 4, 10);
  EXPECT_TRUE(session_.unpark(*cold));
  EXPECT_EQ(session_.beginChunk()->header.request, 1u);
}

TEST_F(SessionHandlesTest, sendsUnrequestedBlobsInOrderAndLetsRequestsPass) {
  send(proto::Hello{});
  send(proto::Open{"a", {}});
  control();
  const auto page = session_.beginChunk();
  session_.parkChunk();
  EXPECT_FALSE(session_.beginChunk());
  request(RequestClass::kVisible, 1, 3, 1);
  EXPECT_EQ(sendChunk(), 1u);
  EXPECT_TRUE(session_.unpark(*page));
  EXPECT_EQ(session_.beginChunk()->blob, kPageBlob);
}

}  // namespace
}  // namespace lode::serve
