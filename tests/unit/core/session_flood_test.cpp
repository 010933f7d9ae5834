#include <gtest/gtest.h>

#include "client/core/session/session.h"
#include "tests/unit/core/session_fixture.h"

namespace lode::core {
namespace {

using namespace fixture;

constexpr size_t kFlood = 20'000;
const Bytes kPing = proto::encode(proto::Ping{7}, 3);

Bytes floodOfPings(size_t count) {
  Bytes bytes;
  for (uint64_t ping = 1; ping <= count; ++ping) {
    const Bytes frame = proto::encode(proto::Ping{ping}, 3);
    bytes.insert(bytes.end(), frame.begin(), frame.end());
  }
  return bytes;
}

std::vector<Request> requestsFor(uint32_t first, size_t count, uint32_t blob_bytes = 10) {
  std::vector<Request> requests;
  for (uint32_t number = first; number < first + count; ++number)
    requests.push_back({{number, blob_bytes, {}}, {}, proto::RequestClass::kVisible, 10});
  return requests;
}

TEST_F(SessionTest, queuesNoMoreAnswersThanTheLimitWhateverTheServerSends) {
  open();
  give(floodOfPings(kFlood));
  EXPECT_FALSE(session_.takesInput());
  EXPECT_LE(session_.takeOutgoing().size(), proto::kMaxQueuedAnswerBytes + kPing.size());
}

TEST_F(SessionTest, answersEveryPingInOrderAsItsAnswersAreTaken) {
  open();
  session_.receive(floodOfPings(kFlood), kStart);
  std::vector<uint64_t> answered;
  do {
    while (session_.nextEvent()) {
    }
    for (const auto& pong : messagesOf<proto::Pong>(session_.takeOutgoing(), FrameType::kPong))
      answered.push_back(pong.payload);
  } while (!session_.takesInput());
  ASSERT_EQ(answered.size(), kFlood);
  for (uint64_t ping = 1; ping <= kFlood; ++ping) ASSERT_EQ(answered[ping - 1], ping);
}

TEST_F(SessionTest, readsOnWhileItsOwnRequestsWait) {
  open();
  for (uint32_t set = 0; set < 8; ++set)
    session_.setRequests(requestsFor(10 + 2000 * set, kMaxRequestsAtOnce));
  give(kPing);
  EXPECT_TRUE(session_.takesInput()) << "a server that waits for its answers to be read would wait for ever";
}

TEST_F(SessionTest, givesUpOnAServerThatSendsButNeverReads) {
  open();
  give(floodOfPings(kFlood));
  const TimePoint almost = listen(kStart, static_cast<int>(kSilenceLimit.count()) - 1);
  try {
    listen(almost, 1);
    FAIL() << "it waits for ever";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kTimeout);
    EXPECT_NE(std::string(error.what()).find("read nothing for 30 seconds"), std::string::npos)
        << error.what();
  }
}

TEST_F(SessionTest, toleratesAServerThatFloodsButReadsSlowly) {
  open();
  give(floodOfPings(kFlood));
  TimePoint now = kStart;
  for (int turn = 0; !session_.takesInput(); ++turn) {
    ASSERT_NO_THROW(now = listen(now, 5)) << turn;
    session_.takeOutgoing();
    while (session_.nextEvent()) {
    }
  }
  EXPECT_GT(now - kStart, kSilenceLimit);
}

TEST_F(SessionTest, queuesNoRequestsBehindALongQueue) {
  open();
  bool is_queued = true;
  for (uint32_t set = 0; set < 100; ++set)
    is_queued = session_.setRequests(requestsFor(10 + 2000 * set, kMaxRequestsAtOnce));
  EXPECT_FALSE(is_queued);
  EXPECT_LE(session_.takeOutgoing().size(), 3 * proto::kMaxQueuedAnswerBytes);
  EXPECT_TRUE(session_.setRequests(requestsFor(1, 1)));
}

TEST_F(SessionTest, keepsFewRequestsOfAServerThatEndsNone) {
  open();
  for (uint32_t set = 0; set < 40; ++set) {
    session_.setRequests(requestsFor(10 + 2000 * set, kMaxRequestsAtOnce));
    session_.takeOutgoing();
  }
  EXPECT_EQ(session_.openRequests(), kMaxUnendedRequests);
}

/// Requests blobs in turn; the server sends all but the last byte of each and ends none.
TEST_F(SessionTest, keepsFewBytesOfCancelledRequestsThatNeverEnd) {
  constexpr uint32_t kBlobBytes = 1u << 20, kBlobs = kMaxCancelledBytes / kBlobBytes + 3;
  open();
  std::vector<uint32_t> requests;
  for (uint32_t blob = 0; blob < kBlobs; ++blob) {
    requests.push_back(makeRequest(blobRef(10 + blob, kBlobBytes)));
    const Bytes bytes = blobBytes(10 + blob, kBlobBytes);
    for (uint32_t offset = 0; offset < kBlobBytes; offset += proto::kMaxChunkBytes) {
      const size_t size = std::min(proto::kMaxChunkBytes, kBlobBytes - 1 - offset);
      give(chunkFrame(requests.back(), kBlobBytes, offset, std::span(bytes).subspan(offset, size)));
      session_.takeOutgoing();
    }
  }
  session_.setRequests({});
  size_t arrived = 0, cancelled = 0;
  for (uint32_t blob = 0; blob < kBlobs; ++blob) {
    const Bytes bytes = blobBytes(10 + blob, kBlobBytes);
    const auto events =
        give(chunkFrame(requests[blob], kBlobBytes, kBlobBytes - 1, std::span(bytes).last(1)));
    for (const SessionEvent& event : events) {
      arrived += std::holds_alternative<BlobArrived>(event);
      cancelled += std::holds_alternative<RequestCancelled>(event);
    }
  }
  EXPECT_EQ(arrived, kMaxCancelledBytes / kBlobBytes);
  EXPECT_EQ(cancelled, kBlobs - arrived) << "their bytes are dropped, and they may be requested again";
  EXPECT_EQ(session_.openRequests(), 0u);
}

}  // namespace
}  // namespace lode::core
