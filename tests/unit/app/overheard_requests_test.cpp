#include "client/loadtest/overheard_requests.h"

#include <vector>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

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

TEST_F(OverheardRequestsTest, tellsOfARequestWhenItsBlobIsWhole) {
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

TEST_F(OverheardRequestsTest, bearsFramesCutAnywhere) {
  ask(1, 20, 0);
  proto::Bytes bytes = proto::encode(proto::Welcome{}, 1);
  for (const std::byte byte : blobFrame(1, blob_, 0, 300)) bytes.push_back(byte);
  for (const std::byte byte : bytes) overheard_.received({&byte, 1});
  EXPECT_EQ(told_.size(), 1u);
}

TEST_F(OverheardRequestsTest, passesByWhatNobodyAskedFor) {
  overheard_.sent(proto::encode(proto::Credit{1}, 0), 0);
  overheard_.received(blobFrame(0, blob_, 0, 300));
  EXPECT_TRUE(told_.empty());
}

}  // namespace
}  // namespace lode::app
