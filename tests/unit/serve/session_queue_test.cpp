#include <limits>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "server/serve/session/session.h"
#include "tests/unit/serve/session_fixture.h"

namespace lode::serve {
namespace {

using namespace test;

using SessionQueueTest = SessionTest;

TEST_F(SessionQueueTest, sendsARequestInChunksThatMakeUpItsBlob) {
  open();
  request(RequestClass::kVisible, 7, 30, 1, 99);
  send(proto::Credit{1 << 30});
  uint32_t offset = 0;
  while (offset < kLarge) {
    const auto chunk = session_.beginChunk();
    ASSERT_TRUE(chunk);
    EXPECT_EQ(chunk->header, (proto::BlobChunkHeader{7, kLarge, offset}));
    EXPECT_EQ(chunk->call, 99u);
    EXPECT_LE(chunk->bytes, proto::kMaxChunkBytes);
    offset += chunk->bytes;
    EXPECT_TRUE(session_.finishChunk());
  }
  EXPECT_EQ(offset, kLarge);
  EXPECT_FALSE(session_.beginChunk());
}

TEST_F(SessionQueueTest, sendsByClassThenPriorityThenNumber) {
  open();
  request(RequestClass::kPrefetch, 1, 3, 1000);
  request(RequestClass::kVisible, 2, 4, 1);
  request(RequestClass::kMargin, 3, 5, 50);
  request(RequestClass::kVisible, 5, 6, 2);
  request(RequestClass::kVisible, 4, 7, 2);
  request(RequestClass::kVisible, 6, 8, std::numeric_limits<float>::infinity());
  std::vector<uint32_t> order;
  while (const auto sent = sendChunk()) order.push_back(*sent);
  EXPECT_EQ(order, (std::vector<uint32_t>{6, 4, 5, 2, 3, 1}));
}

TEST_F(SessionQueueTest, anUrgentRequestOvertakesBetweenChunks) {
  open();
  send(proto::Credit{1 << 30});
  request(RequestClass::kVisible, 1, 30, 5);
  EXPECT_EQ(sendChunk(), 1u);
  request(RequestClass::kVisible, 2, 3, 6);
  EXPECT_EQ(sendChunk(), 2u);
  EXPECT_EQ(sendChunk(), 1u);
}

TEST_F(SessionQueueTest, reordersOnReprioritiseAndKeepsSentChunks) {
  open();
  send(proto::Credit{1 << 30});
  request(RequestClass::kVisible, 1, 30, 5);
  request(RequestClass::kVisible, 2, 31, 4);
  EXPECT_EQ(sendChunk(), 1u);
  change(RequestAction::kReprioritise, RequestClass::kVisible, 2, 6);
  EXPECT_EQ(sendChunk(), 2u);
  change(RequestAction::kReprioritise, RequestClass::kPrefetch, 2, 100);
  const auto chunk = session_.beginChunk();
  EXPECT_EQ(chunk->header, (proto::BlobChunkHeader{1, kLarge, proto::kMaxChunkBytes}));
}

TEST_F(SessionQueueTest, aCancelledRequestEndsOnceAndSendsNoMore) {
  open();
  send(proto::Credit{1 << 30});
  request(RequestClass::kVisible, 1, 30, 5, 12);
  EXPECT_EQ(sendChunk(), 1u);
  change(RequestAction::kCancel, RequestClass::kVisible, 1);
  change(RequestAction::kCancel, RequestClass::kVisible, 1);
  EXPECT_EQ(only<proto::Cancelled>(FrameType::kCancelled, 12).request, 1u);
  EXPECT_FALSE(session_.beginChunk());
}

TEST_F(SessionQueueTest, changesToARequestThatHasEndedAreIgnored) {
  open();
  request(RequestClass::kVisible, 1, 3, 5);
  EXPECT_EQ(sendChunk(), 1u);
  change(RequestAction::kCancel, RequestClass::kVisible, 1);
  change(RequestAction::kReprioritise, RequestClass::kVisible, 1, 3);
  change(RequestAction::kCancel, RequestClass::kVisible, 4444);
  EXPECT_TRUE(control().empty());
  EXPECT_FALSE(session_.beginChunk());
}

TEST_F(SessionQueueTest, aChunkCancelledWhileItIsReadIsNotSent) {
  open();
  request(RequestClass::kVisible, 1, 3, 5);
  ASSERT_TRUE(session_.beginChunk());
  change(RequestAction::kCancel, RequestClass::kVisible, 1);
  EXPECT_FALSE(session_.finishChunk());
  EXPECT_EQ(only<proto::Cancelled>(FrameType::kCancelled).request, 1u);
}

TEST_F(SessionQueueTest, sendsNoChunkAfterTheSessionIsRefused) {
  open();
  request(RequestClass::kVisible, 1, 30, 1);
  ASSERT_TRUE(session_.beginChunk());
  session_.refuse(WireError::kMalformed, "this is no frame");
  EXPECT_FALSE(session_.finishChunk());
  session_.failChunk(WireError::kNotReady, "the disk failed");
  session_.parkChunk();
  expectClosedWith(WireError::kMalformed);
}

TEST_F(SessionQueueTest, restartsARequestNumberReusedDuringARead) {
  open();
  request(RequestClass::kVisible, 1, 3, 5);
  ASSERT_TRUE(session_.beginChunk());
  change(RequestAction::kCancel, RequestClass::kVisible, 1);
  request(RequestClass::kVisible, 1, 4, 5);
  EXPECT_FALSE(session_.finishChunk());
  control();
  const auto chunk = session_.beginChunk();
  ASSERT_TRUE(chunk);
  EXPECT_EQ(chunk->blob, 4u);
  EXPECT_EQ(chunk->header.offset_bytes, 0u);
}

TEST_F(SessionQueueTest, repeatsAnAbandonedChunk) {
  open();
  request(RequestClass::kVisible, 1, 3, 5);
  const auto first = session_.beginChunk();
  session_.abandonChunk();
  const auto second = session_.beginChunk();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->header, first->header);
}

TEST_F(SessionQueueTest, readsOneChunkAtATime) {
  open();
  request(RequestClass::kVisible, 1, 3, 5);
  request(RequestClass::kVisible, 2, 4, 5);
  EXPECT_TRUE(session_.beginChunk());
  EXPECT_FALSE(session_.beginChunk());
}

TEST_F(SessionQueueTest, endsOnlyTheRequestOfAnUnreadableBlob) {
  open();
  request(RequestClass::kVisible, 1, 3, 5, 31);
  request(RequestClass::kVisible, 2, 4, 4);
  session_.beginChunk();
  session_.failChunk(WireError::kDamagedStore, "blob 3 is damaged");
  const auto error = only<proto::ErrorMessage>(FrameType::kError, 31);
  EXPECT_EQ(error, (proto::ErrorMessage{WireError::kDamagedStore, 1, false, "blob 3 is damaged"}));
  EXPECT_EQ(sendChunk(), 2u);
  EXPECT_FALSE(session_.beginChunk());
}

TEST_F(SessionQueueTest, answersOpenWithAnErrorForAnUnreadableFirstBlob) {
  send(proto::Hello{});
  send(proto::Open{"a", {}}, 21);
  send(proto::Open{"b", {}}, 22);
  control();
  session_.beginChunk();
  session_.failChunk(WireError::kDamagedStore, "damaged");
  const auto error = only<proto::ErrorMessage>(FrameType::kError, 21);
  EXPECT_EQ(error.request, 0u);
  EXPECT_FALSE(error.closes);
  const auto next = session_.beginChunk();
  ASSERT_TRUE(next);
  EXPECT_EQ(next->call, 22u) << "the other model's first blobs still come";
}

TEST_F(SessionQueueTest, anUnknownBlobIsAnErrorThatEndsItsRequest) {
  open();
  for (const uint32_t blob : {0u, 40u, 0xFFFFFFFFu}) {
    request(RequestClass::kVisible, 9, blob, 1, 2);
    const auto error = only<proto::ErrorMessage>(FrameType::kError, 2);
    EXPECT_EQ(error.code, WireError::kNoSuchBlob);
    EXPECT_EQ(error.request, 9u);
  }
  EXPECT_FALSE(session_.closing());
}

TEST_F(SessionQueueTest, closesOnAnUnknownHandle) {
  open();
  send(proto::Requests{2, {}});
  expectClosedWith(WireError::kMalformed);
}

TEST_F(SessionQueueTest, closesOnARequestNumberInUse) {
  open();
  request(RequestClass::kVisible, 1, 30, 1);
  request(RequestClass::kVisible, 1, 31, 1);
  expectClosedWith(WireError::kMalformed);
}

TEST_F(SessionQueueTest, aRequestNumberMayBeUsedAgainOnceItHasEnded) {
  open();
  request(RequestClass::kVisible, 1, 3, 1);
  EXPECT_EQ(sendChunk(), 1u);
  request(RequestClass::kVisible, 1, 4, 1);
  EXPECT_EQ(sendChunk(), 1u);
}

TEST_F(SessionQueueTest, closesOnMoreOpenRequestsThanTheLimit) {
  open();
  for (uint32_t i = 1; i <= limits_.max_open_requests; ++i) request(RequestClass::kVisible, i, 30, 1);
  EXPECT_TRUE(control().empty());
  request(RequestClass::kVisible, 5000, 30, 1);
  expectClosedWith(WireError::kLimit);
}

TEST_F(SessionQueueTest, beginsWithTheInitialWindow) {
  open();
  const uint64_t unasked = 2 * proto::kBlobChunkHeaderBytes + 300 + kSmall;
  request(RequestClass::kVisible, 1, 30, 1);
  while (sendChunk()) {
  }
  EXPECT_EQ(sent_bytes_ + unasked, proto::kInitialWindowBytes);
}

TEST_F(SessionQueueTest, creditIsCumulativeAndNeverShrinks) {
  open();
  request(RequestClass::kVisible, 1, 30, 1);
  while (sendChunk()) {
  }
  const uint64_t before = sent_bytes_;
  send(proto::Credit{10});
  EXPECT_FALSE(sendChunk());
  send(proto::Credit{proto::kInitialWindowBytes + 20'000});
  send(proto::Credit{proto::kInitialWindowBytes + 5'000});
  while (sendChunk()) {
  }
  EXPECT_EQ(sent_bytes_ - before, 20'000u);
}

TEST_F(SessionQueueTest, distinguishesWaitsForTheWindowFromServerTime) {
  open();
  request(RequestClass::kVisible, 1, 30, 1);
  EXPECT_FALSE(session_.waitsForWindow());
  while (sendChunk()) {
  }
  EXPECT_TRUE(session_.waitsForWindow());
  session_.onBackpressure(now_);
  now_ += 5s;
  request(RequestClass::kVisible, 2, 3, 2);  // only the later backpressure counts
  now_ += 2s;
  send(proto::Credit{1 << 30});
  session_.onWritable(now_);
  EXPECT_FALSE(session_.waitsForWindow());
  now_ += 1s;
  const auto chunk = session_.beginChunk();
  ASSERT_TRUE(chunk);
  EXPECT_EQ(chunk->header.request, 2u);
  EXPECT_EQ(now_ - chunk->asked, 3s);
  EXPECT_EQ(session_.heldSince(*chunk, now_), 2s);
}

TEST_F(SessionQueueTest, waitsForTheWindowUntilTheLeastChunkFits) {
  open();
  request(RequestClass::kVisible, 1, 30, 1);
  while (sendChunk()) {
  }
  const uint64_t enough = proto::kInitialWindowBytes + proto::kBlobChunkHeaderBytes + kMinChunkBytes;
  send(proto::Credit{enough - 1});
  EXPECT_TRUE(session_.waitsForWindow());
  EXPECT_FALSE(session_.beginChunk());
  send(proto::Credit{enough});
  EXPECT_FALSE(session_.waitsForWindow());
  EXPECT_TRUE(session_.beginChunk());
}

TEST_F(SessionQueueTest, doesNotWaitForTheWindowWhileRequestsWaitForTheDisk) {
  open();
  EXPECT_FALSE(session_.waitsForWindow());
  request(RequestClass::kVisible, 1, 30, 1);
  while (sendChunk()) {
  }
  send(proto::Credit{1 << 30});
  const auto chunk = session_.beginChunk();
  session_.parkChunk();
  EXPECT_FALSE(session_.waitsForWindow());
  session_.unpark(*chunk);
  EXPECT_FALSE(session_.waitsForWindow());
}

TEST_F(SessionQueueTest, theWindowIsNeverExceededWhateverTheClientDoes) {
  auto random = [engine = std::mt19937(7)]() mutable { return static_cast<uint32_t>(engine()); };
  open();
  uint64_t granted = proto::kInitialWindowBytes;
  sent_bytes_ = 2 * proto::kBlobChunkHeaderBytes + 300 + kSmall;
  for (int round = 0; round < 5000; ++round) {
    const uint32_t id = 1 + random() % 50;
    const auto priority_px = static_cast<float>(random() % 100);
    const auto request_class = static_cast<RequestClass>(random() % 3);
    const uint32_t what = random() % 10;
    if (what < 2) {
      change(RequestAction::kCancel, request_class, id);
      request(request_class, id, kFirstBlob + random() % 37, priority_px);
    } else if (what < 4) {
      change(RequestAction::kReprioritise, request_class, id, priority_px);
    } else if (what < 6) {
      granted += random() % 20'000;
      send(proto::Credit{granted});
    }
    control();
    sendChunk();
    ASSERT_LE(sent_bytes_, granted);
  }
  EXPECT_FALSE(session_.closing());
  EXPECT_GT(sent_bytes_, granted - kLarge) << "and it is made use of";
}

TEST_F(SessionQueueTest, everyRequestHasExactlyOneEnding) {
  auto random = [engine = std::mt19937(8)]() mutable { return static_cast<uint32_t>(engine()); };
  open();
  send(proto::Credit{1ull << 40});
  std::map<uint32_t, int> endings;
  std::map<uint32_t, uint32_t> progress;
  const auto take = [&] {
    for (const auto& frame : control()) {
      if (frame.header.type == static_cast<uint8_t>(FrameType::kCancelled))
        ++endings[proto::decode<proto::Cancelled>(frame.body).request];
      if (frame.header.type == static_cast<uint8_t>(FrameType::kError))
        ++endings[proto::decode<proto::ErrorMessage>(frame.body).request];
    }
  };
  uint32_t next = 1;
  for (int round = 0; round < 4000; ++round) {
    if (next <= 1000 && random() % 2 == 0) {
      request(RequestClass::kVisible, next, random() % 41, static_cast<float>(random() % 100));
      if (session_.closing()) break;
      ++next;
    }
    if (random() % 3 == 0) change(RequestAction::kCancel, RequestClass::kVisible, 1 + random() % next);
    take();
    for (int chunks = 0; chunks < 4; ++chunks) {
      const auto chunk = session_.beginChunk();
      if (!chunk) break;
      if (random() % 10 == 0) change(RequestAction::kCancel, RequestClass::kVisible, chunk->header.request);
      if (random() % 20 == 0) {
        session_.failChunk(WireError::kInternal, "no");
      } else if (session_.finishChunk()) {
        EXPECT_EQ(endings[chunk->header.request], 0) << "a chunk after the ending";
        EXPECT_EQ(chunk->header.offset_bytes, progress[chunk->header.request]);
        progress[chunk->header.request] += chunk->bytes;
        if (progress[chunk->header.request] == chunk->header.total_bytes) ++endings[chunk->header.request];
      }
      take();
    }
  }
  while (const auto chunk = session_.beginChunk()) {
    session_.finishChunk();
    progress[chunk->header.request] += chunk->bytes;
    if (progress[chunk->header.request] == chunk->header.total_bytes) ++endings[chunk->header.request];
  }
  ASSERT_EQ(next, 1001u);
  for (uint32_t id = 1; id < next; ++id) EXPECT_EQ(endings[id], 1) << id;
}

TEST_F(SessionQueueTest, sendsNoTinyChunksIfTheWindowOpensSlowly) {
  open();
  request(RequestClass::kVisible, 1, 30, 1);
  while (sendChunk()) {
  }
  uint64_t granted = proto::kInitialWindowBytes;
  while (granted < proto::kInitialWindowBytes + 50'000) {
    send(proto::Credit{granted += 100});
    const uint64_t before = sent_bytes_;
    if (sendChunk()) {
      EXPECT_GE(sent_bytes_ - before, kMinChunkBytes);
    }
  }
  EXPECT_GT(sent_bytes_ + 2 * kMinChunkBytes, granted);
}

TEST_F(SessionQueueTest, theRestOfABlobIsSentHoweverShort) {
  open();
  request(RequestClass::kVisible, 1, 30, 1);
  const uint32_t chunks = (kLarge + proto::kMaxChunkBytes - 1) / proto::kMaxChunkBytes;
  const uint64_t unasked = 2 * proto::kBlobChunkHeaderBytes + 300 + kSmall;
  send(proto::Credit{unasked + kLarge + chunks * proto::kBlobChunkHeaderBytes});
  uint32_t count = 0;
  while (sendChunk()) ++count;
  EXPECT_EQ(count, chunks);
}

}  // namespace
}  // namespace lode::serve
