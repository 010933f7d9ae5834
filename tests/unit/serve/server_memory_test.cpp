// A server short of memory refuses and closes large connections, serves small ones and frees all memory.

#include <algorithm>
#include <memory>
#include <vector>

#include "server/serve/net/connection.h"
#include "tests/unit/serve/allocations.h"
#include "tests/unit/serve/server_fixture.h"

namespace lode::serve {
namespace {

using namespace test;

class ServerMemory : public ServerTest {
 protected:
  using Clients = std::vector<std::unique_ptr<TestClient>>;

  /// Connects clients that open "a" and read nothing afterwards.
  Clients openMany(int count) {
    Clients clients;
    for (int i = 0; i < count; ++i) {
      clients.push_back(std::make_unique<TestClient>(server_->port()));
      clients.back()->open("a");
    }
    return clients;
  }
  static void requestTimes(TestClient& client, uint32_t count) {
    for (uint32_t request = 1; request <= count;) {
      proto::Requests requests{1, {}};
      for (uint32_t n = 0; n < proto::kMaxRequestsPerFrame && request <= count; ++n)
        requests.changes.push_back({RequestAction::kAdd, RequestClass::kVisible, request++, 5, 1});
      client.send(requests);
    }
  }
  /// Sends the first part of a frame, which holds memory until the rest arrives.
  static void sendPartOfAFrame(TestClient& client, size_t bytes) {
    client.sendBytes(proto::encodeFrameHeader(
        {proto::kMaxFrameBodyBytes, static_cast<uint8_t>(FrameType::kRequests), 0, 1}));
    client.sendBytes(proto::Bytes(bytes));
  }
  /// Evicts a file from the page cache.
  static void forget(const std::filesystem::path& path) {
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    ::fsync(file);
    ::posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
    ::close(file);
  }
  /// Waits up to a second, less than a refused client may linger. @return true if the condition became true.
  static bool soon(const auto& is_so) {
    const auto end = std::chrono::steady_clock::now() + 1s;
    while (!is_so())
      if (std::chrono::steady_clock::now() > end) return false;
    return true;
  }
  /// Discards received bytes. @return true if the connection has ended.
  static bool hasEnded(TestClient& client) {
    client.socket().non_blocking(true);
    std::array<std::byte, 4096> dropped;
    asio::error_code error;
    while (!error) client.socket().read_some(asio::buffer(dropped), error);
    return error != asio::error::would_block;
  }
};

TEST_F(ServerMemory, isChargedForReceivedNotForAnnouncedBytes) {
  options_.memory_budget_bytes = 4u << 20;
  start();
  std::vector<std::unique_ptr<TestClient>> many;
  for (int i = 0; i < 100; ++i) {  // announces 25 MB
    many.push_back(std::make_unique<TestClient>(server_->port()));
    many.back()->send(proto::Hello{});
    many.back()->expect<proto::Welcome>(FrameType::kWelcome);
    many.back()->sendBytes(proto::encodeFrameHeader(
        {proto::kMaxFrameBodyBytes, static_cast<uint8_t>(FrameType::kRequests), 0, 1}));
  }
  expectServed();
}

TEST_F(ServerMemory, greedyConnectionsAreRefusedAndPoliteOnesServed) {
  options_.memory_budget_bytes = 4u << 20;
  start();
  const Clients greedy = openMany(40);
  for (const auto& client : greedy) requestTimes(*client, 4 * proto::kMaxRequestsPerFrame);
  for (int i = 0; i < 5; ++i) expectServed();
}

TEST_F(ServerMemory, closesGreedyButNotPoliteConnectionsWhenExhausted) {
  options_.memory_budget_bytes = 4u << 20;
  options_.handshake_deadline = 400ms;  // the sweep runs four times within the shortest deadline
  start();
  TestClient polite = connect();
  const proto::Opened opened = polite.open("a");
  polite.blobs(2);
  Clients quiet = openMany(20);
  const Clients greedy = openMany(70);
  for (const auto& client : greedy) requestTimes(*client, 480);  // 60 KB each, below the limit
  const auto end = std::chrono::steady_clock::now() + 20s;
  size_t closed = 0;
  while (closed == 0 && std::chrono::steady_clock::now() < end) {
    polite.send(requestsAll(opened.handle));
    ASSERT_EQ(polite.blobs(reader().blobCount()).size(), reader().blobCount());
    closed = static_cast<size_t>(std::ranges::count_if(greedy, [](const auto& c) { return hasEnded(*c); }));
  }
  EXPECT_GT(closed, 0u) << "no connection was closed";
  EXPECT_LT(closed, 40u) << "more than needed";
  for (const auto& client : quiet) EXPECT_FALSE(hasEnded(*client));
  EXPECT_TRUE(isLetInSoon());
}

TEST_F(ServerMemory, theGreediestAreClosedFirst) {
  options_.memory_budget_bytes = 1u << 20;  // closing one or two connections of 60 KB is enough
  options_.threads = 1;
  start();
  const Clients modest = openMany(2), greedy = openMany(2);
  for (const auto& client : modest) sendPartOfAFrame(*client, 28u << 10);
  for (const auto& client : greedy) sendPartOfAFrame(*client, 60u << 10);
  const auto someEnded = [](const Clients& of) {
    return std::ranges::any_of(of, [](const auto& client) { return hasEnded(*client); });
  };
  Clients quiet;
  while (server_->memoryHeld() <= options_.memory_budget_bytes / 16 * 13 && !someEnded(greedy))
    quiet.push_back(std::move(openMany(1)[0]));
  EXPECT_TRUE(soon([&] { return someEnded(greedy); }));
  EXPECT_FALSE(someEnded(modest));
}

TEST_F(ServerMemory, closesNoMoreConnectionsThanNeeded) {
  options_.memory_budget_bytes = 4u << 20;
  start();
  Clients quiet = openMany(20), greedy = openMany(70);
  for (const auto& client : greedy) sendPartOfAFrame(*client, 60u << 10);
  const auto closed = [&] {
    return static_cast<size_t>(std::ranges::count_if(greedy, [](const auto& c) { return hasEnded(*c); }));
  };
  // From 12/16 to 13/16 no connection is closed, so the use may stay there.
  EXPECT_TRUE(soon([&] {
    return closed() > 0 && server_->memoryHeld() <= options_.memory_budget_bytes / 16 * 13;
  })) << server_->memoryHeld();
  expectServed();
  EXPECT_LT(closed(), 40u);
  for (const auto& client : quiet) EXPECT_FALSE(hasEnded(*client));
}

TEST_F(ServerMemory, admitsClientsSoonAfterAnExhaustingFlood) {
  options_.memory_budget_bytes = 4u << 20;
  start();
  Clients flood = openMany(40);
  for (int i = 0; i < 200; ++i) {
    flood.push_back(std::make_unique<TestClient>(server_->port()));
    flood.back()->send(proto::Hello{});
    sendPartOfAFrame(*flood.back(), 60u << 10);
  }
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(isLetInSoon());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 1s);
}

TEST_F(ServerMemory, isReturnedAfterAFrameThatDoesNotFit) {
  // 1/64 of 3/4 of this budget is 48 KB, so every charge above 64 KB fails.
  options_.memory_budget_bytes = 4u << 20;
  start();
  TestClient client = connect();
  client.open("a");
  client.blobs(2);
  client.sendBytes(proto::encodeFrameHeader(
      {proto::kMaxFrameBodyBytes, static_cast<uint8_t>(FrameType::kRequests), 0, 1}));
  client.sendBytes(proto::Bytes(200'000));
  EXPECT_EQ(client.expect<proto::ErrorMessage>(FrameType::kError).code, WireError::kLimit);
  EXPECT_TRUE(soon([&] { return server_->memoryHeld() < kPlainConnectionBytes + (4u << 10); }))
      << server_->memoryHeld() << " while the client is still connected";
}

TEST_F(ServerMemory, doesNotCountDiskReadsAsGreed) {
  options_.memory_budget_bytes = 5'736'000;  // a connection may hold two chunks and eight requests of it
  start();
  TestClient client = connect();
  const proto::Opened opened = client.open("a");
  client.blobs(2);
  for (int round = 0; round < 20; ++round) {
    forget(store_);
    client.send(requestsAll(opened.handle));
    client.send(proto::Credit{1ull << 40});
    client.send(proto::Ping{1}, 1);
    for (size_t complete = 0; complete < reader().blobCount();) {
      const auto frame = client.receive();
      ASSERT_TRUE(frame && !frame->is(FrameType::kError)) << "in round " << round;
      if (frame->is(FrameType::kPong)) client.send(proto::Ping{1}, 1);
      if (!frame->is(FrameType::kBlob)) continue;
      const proto::BlobChunk chunk = proto::decodeBlobChunk(frame->body);
      complete += chunk.header.offset_bytes + chunk.bytes.size() == chunk.header.total_bytes ? 1 : 0;
    }
  }
}

TEST_F(ServerMemory, refusesTheNextConnectionWithAnErrorWhenShort) {
  // Connections are admitted up to 7/8 of the budget: room for seven connections and their Hellos.
  options_.memory_budget_bytes = kPlainConnectionBytes * 15 / 2 * 8 / 7;
  start();
  std::vector<std::unique_ptr<TestClient>> clients;
  for (int i = 0; i < 7; ++i) {
    clients.push_back(std::make_unique<TestClient>(server_->port()));
    clients.back()->send(proto::Hello{});
    clients.back()->expect<proto::Welcome>(FrameType::kWelcome);
  }
  connect().expectErrorAndEnd(WireError::kLimit);
}

TEST_F(ServerMemory, releasesTheSlotOfAConnectionWithoutMemory) {
  options_.max_connections = 1;
  start();
  {
    // A Connection with the control block of its shared_ptr.
    const auto failing = FailingAllocations::ofSize(sizeof(Connection), sizeof(Connection) + 64);
    connect().receive();
    EXPECT_GT(failing.failed(), 0u);
  }
  EXPECT_TRUE(isLetInSoon());
}

TEST_F(ServerMemory, mayRunOutAnywhereDuringAnAcceptAndTheNextIsServed) {
  start();
  expectServed();
  for (size_t nth = 0, failed = 1; failed > 0; ++nth) {
    const auto failing = FailingAllocations::nthOf(thread_.get_id(), nth);
    TestClient client = connect();
    client.send(proto::Hello{});
    client.receive();  // Welcome, or the end of the connection
    failed = failing.failed();
  }
  expectServed();
}

TEST_F(ServerMemory, mayRunOutAnywhereDuringASessionAndTheNextIsServed) {
  options_.threads = 1;
  start();
  expectServed();
  for (size_t nth = 0, failed = 1; failed > 0; ++nth) {
    const auto failing = FailingAllocations::nthOfOthers(nth);
    TestClient client = connect();
    client.send(proto::Hello{});
    client.send(proto::Open{"a", {}});
    client.send(requestsAll(1));
    client.send(proto::Ping{1});
    for (auto frame = client.receive(); frame && !frame->is(FrameType::kPong);) frame = client.receive();
    failed = failing.failed();
  }
  expectServed();
}

}  // namespace
}  // namespace lode::serve
