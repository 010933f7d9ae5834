// Cost of a request if its blob is in the page cache.

#include "tests/unit/serve/allocations.h"
#include "tests/unit/serve/server_fixture.h"

namespace lode::serve {
namespace {

using namespace test;

class HotPath : public ServerTest {
 protected:
  /// Sends the requests, eight in a frame, and receives their blobs.
  void request(TestClient& client, uint32_t handle, uint32_t count) {
    for (uint32_t request = 1; request <= count; request += 8) {
      proto::Requests requests{handle, {}};
      for (uint32_t n = 0; n < 8; ++n)
        requests.changes.push_back({RequestAction::kAdd, RequestClass::kVisible, request + n, n + 3, 1});
      client.send(requests);
      ASSERT_EQ(client.blobs(8).size(), 8u);
    }
  }
};

TEST_F(HotPath, takesAtMostTwoAllocationsForARequest) {
  options_.threads = 1;
  start();
  TestClient client = connect();
  const proto::Opened opened = client.open("a");
  client.blobs(2);
  request(client, opened.handle, 1000);
  const AllocationsOfOthers allocations;
  request(client, opened.handle, 10'000);
  EXPECT_LT(allocations.count(), 20'100u) << "by ten thousand requests";
}

TEST_F(HotPath, letsTheMemoryOfALargeFrameGo) {
  options_.threads = 1;
  start();
  TestClient client = connect();
  client.open("a");
  client.blobs(2);
  const proto::Bytes body(200'000);
  const auto large = [&] {
    client.sendBytes(proto::encodeFrameHeader({200'000, 200, proto::kFlagOptional, 0}));
    client.sendBytes(body);
    client.send(proto::Ping{1}, 1);
  };
  large();
  client.expect<proto::Pong>(FrameType::kPong);
  const FailingAllocations failing = FailingAllocations::ofSize(16 << 10, 1 << 20);
  large();
  client.receive();
  EXPECT_GT(failing.failed(), 0u) << "a second frame like the first found room without asking";
}

}  // namespace
}  // namespace lode::serve
