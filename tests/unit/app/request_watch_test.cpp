#include "client/loadtest/request_watch.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "proto/limits.h"

namespace lode::app {
namespace {

using namespace std::chrono_literals;
using proto::RequestAction;
using proto::RequestClass;

constexpr core::TimePoint kThen{10s};

void say(RequestClock& clock, RequestAction action, uint32_t request, uint32_t blob,
         core::TimePoint now = kThen, RequestClock::Requests&& lost = {}) {
  clock.sent(proto::encode(proto::Requests{1, {{action, RequestClass::kMargin, request, blob, 2.5f}}}, 3),
             now, lost);
}

TEST(RequestClock, givesTheSendingTimeOfABlobsRequest) {
  RequestClock clock;
  say(clock, RequestAction::kAdd, 9, 20);
  const auto request = clock.arrived(20);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->sent, kThen);
  EXPECT_EQ(request->request_class, RequestClass::kMargin);
  EXPECT_TRUE(clock.open().empty());
}

TEST(RequestClock, hasNoTimeForUnrequestedBlobs) { EXPECT_FALSE(RequestClock().arrived(20)); }

TEST(RequestClock, forgetsCancelledRequests) {
  RequestClock clock;
  say(clock, RequestAction::kAdd, 9, 20);
  say(clock, RequestAction::kAdd, 10, 21);
  say(clock, RequestAction::kCancel, 9, 0);
  EXPECT_FALSE(clock.arrived(20));
  EXPECT_TRUE(clock.arrived(21));
}

TEST(RequestClock, timesARepeatedRequestFromItsRepetition) {
  RequestClock clock;
  say(clock, RequestAction::kAdd, 9, 20);
  say(clock, RequestAction::kCancel, 9, 0);
  say(clock, RequestAction::kAdd, 10, 20, kThen + 1s);
  EXPECT_EQ(clock.open().size(), 1u);
  EXPECT_EQ(clock.arrived(20)->sent, kThen + 1s);
}

TEST(RequestClock, timesALostRequestFromItsFirstSending) {
  RequestClock::Requests lost{{20, {5, RequestClass::kVisible, kThen}},
                              {21, {6, RequestClass::kVisible, kThen}}};
  RequestClock clock;
  clock.sent(
      proto::encode(proto::Requests{1, {{RequestAction::kAdd, RequestClass::kMargin, 9, 20, 2.5f}}}, 3),
      kThen + 3s, lost);
  EXPECT_EQ(clock.arrived(20)->sent, kThen);
  EXPECT_EQ(lost.size(), 1u) << "the other may be made again later";
}

TEST(LostRequests, areRememberedUpToALimit) {
  RequestClock::Requests lost;
  for (uint32_t connection = 0; connection < 10; ++connection) {
    RequestClock::Requests open;
    for (uint32_t blob = 0; blob < 1000; ++blob)
      open[1000 * connection + blob] = {blob, RequestClass::kVisible, kThen};
    const size_t before = lost.size();
    const size_t left_out = addLost(lost, open).size();
    EXPECT_EQ(lost.size() + left_out, before + open.size());
  }
  EXPECT_EQ(lost.size(), kMaxLostRequests);
}

TEST(RequestClock, keepsTheSendingTimeOnANewPriority) {
  RequestClock clock;
  say(clock, RequestAction::kAdd, 9, 20);
  say(clock, RequestAction::kReprioritise, 9, 0, kThen + 1s);
  EXPECT_EQ(clock.arrived(20)->sent, kThen);
}

using proto::RequestAction;
using proto::RequestClass;

proto::Bytes blobFrame(uint32_t request, const std::vector<std::byte>& blob, uint32_t from, uint32_t count) {
  proto::Bytes frame;
  const auto add = [&frame](std::span<const std::byte> bytes) {
    frame.insert(frame.end(), bytes.begin(), bytes.end());
  };
  add(proto::encodeFrameHeader({static_cast<uint32_t>(proto::kBlobChunkHeaderBytes + count),
                                static_cast<uint8_t>(proto::FrameType::kBlob), 0, 3}));
  add(proto::encodeBlobChunkHeader({request, static_cast<uint32_t>(blob.size()), from}));
  add(std::span(blob).subspan(from, count));
  return frame;
}

class OverheardRequestsTest : public testing::Test {
 protected:
  void ask(uint32_t request, uint32_t blob, double now) {
    overheard_.sent(
        proto::encode(proto::Requests{1, {{RequestAction::kAdd, RequestClass::kMargin, request, blob, 2.5f}}},
                      3),
        now);
  }

  void cancel(uint32_t request) {
    overheard_.sent(
        proto::encode(proto::Requests{1, {{RequestAction::kCancel, RequestClass::kMargin, request, 0, 0}}},
                      3),
        0);
  }

  struct Told {
    core::Request request;
    double asked_at;
  };
  std::vector<Told> told_;
  OverheardRequests overheard_{[this](const core::Request& request, double at) {
    told_.push_back({request, at});
  }};
  const std::vector<std::byte> blob_ = std::vector<std::byte>(300, std::byte{7});
};

TEST_F(OverheardRequestsTest, reportsARequestWhenItsBlobIsComplete) {
  ask(9, 20, 1.5);
  overheard_.received(blobFrame(9, blob_, 0, 200));
  EXPECT_TRUE(told_.empty());
  overheard_.received(blobFrame(9, blob_, 200, 100));
  ASSERT_EQ(told_.size(), 1u);
  EXPECT_EQ(told_[0].request.blob, (BlobRef{20, 300, digestOf(blob_)}));
  EXPECT_EQ(told_[0].request.request_class, RequestClass::kMargin);
  EXPECT_EQ(told_[0].request.priority_px, 2.5f);
  EXPECT_EQ(told_[0].asked_at, 1.5);
}

/// The server first sends all but the last byte of each cancelled request, then the last bytes.
TEST_F(OverheardRequestsTest, keepsFewBytesOfCancelledRequestsThatNeverEnd) {
  constexpr uint32_t kBlobBytes = 1u << 20, kBlobs = core::kMaxCancelledBytes / kBlobBytes + 3;
  const std::vector<std::byte> blob(kBlobBytes, std::byte{7});
  const auto send = [&](uint32_t request, uint32_t from, uint32_t to) {
    for (uint32_t at = from; at < to; at += proto::kMaxChunkBytes)
      overheard_.received(blobFrame(request, blob, at, std::min(proto::kMaxChunkBytes, to - at)));
  };
  for (uint32_t request = 1; request <= kBlobs; ++request) {
    ask(request, request, 0);
    if (request % 2 == 0) cancel(request);
    send(request, 0, kBlobBytes - 1);
    if (request % 2 != 0) cancel(request);
  }
  for (uint32_t request = 1; request <= kBlobs; ++request) send(request, kBlobBytes - 1, kBlobBytes);
  EXPECT_EQ(told_.size(), core::kMaxCancelledBytes / kBlobBytes);
  ask(kBlobs + 1, 20, 0);
  cancel(kBlobs + 1);
  send(kBlobs + 1, 0, kBlobBytes);
  EXPECT_EQ(told_.back().request.blob.number, 20u) << "ended requests count no longer";
}

TEST_F(OverheardRequestsTest, readsFramesSplitAnywhere) {
  ask(1, 20, 0);
  proto::Bytes bytes = proto::encode(proto::Welcome{}, 1);
  for (const std::byte byte : blobFrame(1, blob_, 0, 300)) bytes.push_back(byte);
  for (const std::byte byte : bytes) overheard_.received({&byte, 1});
  EXPECT_EQ(told_.size(), 1u);
}

TEST_F(OverheardRequestsTest, ignoresUnrequestedBlobs) {
  overheard_.sent(proto::encode(proto::Credit{1}, 0), 0);
  overheard_.received(blobFrame(0, blob_, 0, 300));
  EXPECT_TRUE(told_.empty());
}

}  // namespace
}  // namespace lode::app
