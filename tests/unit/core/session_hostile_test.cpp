#include <gtest/gtest.h>

#include "client/core/session/session.h"
#include "tests/unit/core/session_fixture.h"

namespace lode::core {
namespace {

using namespace fixture;

TEST_F(SessionTest, refusesMoreBytesThanTheServerCanHaveBeenGranted) {
  open();
  constexpr size_t kSize = proto::kInitialWindowBytes + proto::kMaxChunkBytes;
  const uint32_t request = makeRequest(blobRef(5, kSize));
  expectRefused(blobFrames(request, 5, kSize), "credit");
}

TEST_F(SessionTest, refusesMoreThanTheFirstWindowBeforeACreditWasSent) {
  session_.takeOutgoing();
  give(welcome() + opened() + blobFrames(0, kPageBlob, kPageBytes));
  session_.expectUnasked(blobRef(5, proto::kInitialWindowBytes), {});
  expectRefused(blobFrames(0, 5, proto::kInitialWindowBytes), "credit");
}

TEST_F(SessionTest, refusesAnAnswerOutOfTurn) { expectRefused(opened(), "unexpected"); }

TEST_F(SessionTest, refusesASecondWelcome) {
  give(welcome());
  expectRefused(welcome(), "unexpected");
}

TEST_F(SessionTest, refusesAnAnswerToAnotherCall) {
  expectRefused(proto::encode(proto::Welcome{proto::kProtocolVersion, 0, 16, ""}, 9), "unexpected");
}

TEST_F(SessionTest, refusesAVersionThatItDidNotOffer) {
  expectRefused(proto::encode(proto::Welcome{proto::kProtocolVersion + 1, 0, 16, ""}, 1), "it chose version");
}

TEST_F(SessionTest, refusesAServerWithoutRequests) {
  expectRefused(proto::encode(proto::Welcome{proto::kProtocolVersion, 0, 0, ""}, 1), "no requests");
}

TEST_F(SessionTest, refusesABlobThatWasNotRequested) {
  open();
  expectRefused(blobFrames(99, 5, 100), "not requested");
}

TEST_F(SessionTest, refusesAnUnrequestedBlobBeyondTheAnnouncedOnes) {
  open();
  expectRefused(blobFrames(0, 5, 100), "not requested");
}

TEST_F(SessionTest, refusesABlobOfAnotherSize) {
  open();
  const uint32_t request = makeRequest(blobRef(5, 100));
  expectRefused(blobFrames(request, 5, 101), "another size");
}

TEST_F(SessionTest, refusesAChunkOutOfOrder) {
  open();
  const uint32_t request = makeRequest(blobRef(5, 100));
  expectRefused(chunkFrame(request, 100, 50, blobBytes(5, 50)), "out of order");
}

TEST_F(SessionTest, refusesAChunkThatOverlapsTheOneBefore) {
  open();
  const uint32_t request = makeRequest(blobRef(5, 100));
  give(chunkFrame(request, 100, 0, blobBytes(5, 60)));
  expectRefused(chunkFrame(request, 100, 50, blobBytes(5, 50)), "out of order");
}

TEST_F(SessionTest, refusesAChunkBeyondTheEndOfItsBlob) {
  open();
  const uint32_t request = makeRequest(blobRef(5, 100));
  give(chunkFrame(request, 100, 0, blobBytes(5, 60)));
  expectRefused(chunkFrame(request, 100, 60, blobBytes(5, 41)), "beyond");
}

TEST_F(SessionTest, refusesABlobWithAnotherDigest) {
  open();
  const uint32_t request = makeRequest(blobRef(5, 100));
  expectRefused(blobFrames(request, 6, 100), "digest");
}

TEST_F(SessionTest, refusesAnErrorForARequestThatIsNotOpen) {
  open();
  expectRefused(proto::encode(proto::ErrorMessage{proto::WireError::kInternal, 44, false, "x"}, 0),
                "not open");
}

TEST_F(SessionTest, refusesAnUnrequestedCancellation) {
  open();
  const uint32_t request = makeRequest(blobRef(5, 100));
  expectRefused(proto::encode(proto::Cancelled{request}, 0), "cancelled");
}

TEST_F(SessionTest, refusesAPongWithoutAPing) {
  give(welcome());
  expectRefused(proto::encode(proto::Pong{5}, 0), "Pong");
}

TEST_F(SessionTest, refusesAFrameThatIsNotForAClient) {
  expectRefused(proto::encode(proto::Hello{}, 1), "not sent to clients");
}

TEST_F(SessionTest, refusesAnUnknownFrameThatIsNotOptional) {
  expectRefused(frameOf(static_cast<FrameType>(77), 0, blobBytes(1, 20)), "77");
}

TEST_F(SessionTest, refusesATooLongFrameBeforeItsBodyArrives) {
  open();
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

TEST_F(SessionTest, refusesAnotherModelThanTheOneThatItOpened) {
  proto::Opened message;
  message.handle = 1;
  message.summary.name = "other";
  message.summary.root_page = blobRef(kPageBlob, kPageBytes);
  give(welcome());
  expectRefused(proto::encode(message, 2), "another model");
}

TEST_F(SessionTest, refusesAFirstPageWithoutBytes) {
  proto::Opened message;
  message.handle = 1;
  message.summary.name = "model";
  message.summary.root_page = {kPageBlob, 0, {}};
  give(welcome());
  expectRefused(proto::encode(message, 2), "0 bytes");
}

}  // namespace
}  // namespace lode::core
