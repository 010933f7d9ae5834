// Faults of one client or of the system must not affect other sessions.

#include <filesystem>
#include <vector>

#include <asio/steady_timer.hpp>
#include <sys/resource.h>

#include "server/serve/net/acceptor.h"
#include "tests/unit/serve/server_fixture.h"

namespace lode::serve {
namespace {

using namespace test;

using ServerFaults = ServerTest;
using Clock = std::chrono::steady_clock;

/// Sends pings until the connection breaks or the time is over. @return true if it broke.
bool isGivenUp(TestClient& client, Clock::duration within) {
  const auto end = Clock::now() + within;
  asio::error_code error;
  while (!error && Clock::now() < end) {
    asio::write(client.socket(), asio::buffer(proto::encode(proto::Ping{1}, 0)), error);
    std::this_thread::sleep_for(5ms);
  }
  return static_cast<bool>(error);
}

TEST_F(ServerFaults, aClientThatPingsButNeverReadsIsDisconnected) {
  options_.write_deadline = 100ms;
  start();
  TestClient client = connect();
  client.socket().set_option(asio::socket_base::receive_buffer_size(4096));
  const proto::Opened opened = client.open("a");
  client.send(proto::Credit{1ull << 40});
  proto::Requests requests{opened.handle, {}};
  for (uint32_t i = 0; i < 4000; ++i)
    requests.changes.push_back({RequestAction::kAdd, RequestClass::kVisible, i + 1, i % 10 + 1, 1});
  client.send(requests);
  EXPECT_TRUE(isGivenUp(client, 60s));
  expectServed();
}

TEST_F(ServerFaults, aReadingClientWithAShutWindowIsKept) {
  options_.write_deadline = 50ms;
  start();
  TestClient client = connect();
  const proto::Opened opened = client.open("a");
  client.send(requestsAll(opened.handle));
  EXPECT_FALSE(isGivenUp(client, 300ms));
}

TEST_F(ServerFaults, everyRefusedConnectionGetsAnErrorAndTakesNoSlot) {
  options_.max_connections = 2;
  start();
  std::optional<TestClient> first(std::in_place, server_->port());
  TestClient second = connect();
  first->open("a");
  second.open("a");
  std::vector<std::unique_ptr<TestClient>> refused;
  for (int i = 0; i < 120; ++i) {
    refused.push_back(std::make_unique<TestClient>(server_->port()));
    refused.back()->send(proto::Hello{});
  }
  for (auto& client : refused) client->expectErrorAndEnd(WireError::kLimit);
  first.reset();
  EXPECT_TRUE(isLetInSoon()) << "though the refused are still there";
}

TEST_F(ServerFaults, theLimitOfConnectionsPerAddressIsEnforced) {
  options_.max_connections = 2;
  options_.max_connections_per_address = 1;
  start();
  TestClient first = connect();
  first.open("a");
  for (int i = 0; i < 3; ++i) connect().expectErrorAndEnd(WireError::kLimit);
  TestClient other(server_->port(), asio::ip::make_address_v4("127.0.0.2"));
  other.open("a");  // refused clients occupy no slot
}

TEST_F(ServerFaults, aConnectionWithoutAFreeDescriptorGetsAnError) {
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  start();
  TestClient served = connect();
  served.open("a");
  rlimit few = before;
  few.rlim_cur = 400;
  setrlimit(RLIMIT_NOFILE, &few);
  asio::io_context context;
  std::vector<asio::ip::tcp::socket> clients;
  for (int i = 0; i < 3; ++i) {
    clients.emplace_back(context);
    clients.back().open(asio::ip::tcp::v4());
  }
  std::vector<int> taken;
  for (int copy = ::dup(2); copy >= 0; copy = ::dup(2)) taken.push_back(copy);
  for (auto& client : clients) {
    client.connect({asio::ip::address_v4::loopback(), server_->port()});
    std::array<std::byte, proto::kFrameHeaderBytes> head{};
    asio::error_code error;
    asio::read(client, asio::buffer(head), error);
    EXPECT_FALSE(error) << error.message();
    EXPECT_EQ(head[4], static_cast<std::byte>(FrameType::kError));
  }
  for (const int copy : taken) ::close(copy);
  setrlimit(RLIMIT_NOFILE, &before);
  expectServed();
}

TEST_F(ServerFaults, theLimitOfOpenFilesIsRaisedToItsMaximum) {
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  rlimit few = before;
  few.rlim_cur = 300;
  setrlimit(RLIMIT_NOFILE, &few);
  EXPECT_EQ(raiseOpenFileLimit(), before.rlim_max);
  rlimit now{};
  getrlimit(RLIMIT_NOFILE, &now);
  EXPECT_EQ(now.rlim_cur, before.rlim_max);
  setrlimit(RLIMIT_NOFILE, &before);
}

TEST_F(ServerFaults, aBlobOverwrittenUnderASessionEndsItsRequestAsDamaged) {
  start();
  expectServed();
  const uint32_t bad = reader().find(kRootKey.child(3))->lods[0].payload.number;
  TestClient client = connect();
  const proto::Opened opened = client.open("a");
  client.blobs(2);
  test::damage(store_, reader().blob(bad).offset + 100);
  client.send(proto::Requests{opened.handle, {{RequestAction::kAdd, RequestClass::kVisible, 1, bad, 5}}});
  const auto error = client.expect<proto::ErrorMessage>(FrameType::kError);
  EXPECT_EQ(error.code, WireError::kDamagedStore);
  EXPECT_EQ(error.request, 1u);
}

}  // namespace
}  // namespace lode::serve
