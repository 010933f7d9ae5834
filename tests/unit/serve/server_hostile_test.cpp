// Clients that disconnect, stall, send slowly or flood: each is closed or served, and other clients are
// unaffected.

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "tests/support/test_certificate.h"
#include "tests/unit/serve/server_fixture.h"
#include "tests/unit/serve/tls_client.h"

namespace lode::serve {
namespace {

using namespace test;
using Clock = std::chrono::steady_clock;

class ServerHostile : public ServerTest {
 protected:
  void startUnderTls() {
    options_.tls_certificate = folder_.path() / "it.crt";
    options_.tls_key = folder_.path() / "it.key";
    lode::test::writeCertificate(options_.tls_certificate, options_.tls_key);
    start();
  }
  void expectServedUnderTls() {
    TlsClient client(server_->port());
    ASSERT_TRUE(client.connected());
    client.send(proto::Hello{});
    EXPECT_EQ(client.receive(), FrameType::kWelcome);
  }
  /// Floods the server with a frame and reads the answers while another client is served.
  void expectServedBeside(const proto::Bytes& flood) {
    proto::Bytes many;
    while (many.size() < 64u << 10) many.insert(many.end(), flood.begin(), flood.end());
    TestClient client = connect();
    client.open("a");
    std::atomic<bool> over = false;
    std::thread sends([&] {
      asio::error_code error;
      while (!over && !error) asio::write(client.socket(), asio::buffer(many), error);
    });
    std::thread takes([&] {
      asio::error_code error;
      std::array<std::byte, 4096> dropped;
      while (!error) client.socket().read_some(asio::buffer(dropped), error);
    });
    for (int i = 0; i < 3; ++i) expectServed();
    over = true;
    client.socket().shutdown(asio::socket_base::shutdown_both);
    sends.join();
    takes.join();
  }
  static bool endsWithin(TestClient& client, Clock::duration time) {
    const auto end = Clock::now() + time;
    while (client.receive())
      if (Clock::now() > end) return false;
    return Clock::now() < end;
  }
};

TEST_F(ServerHostile, everyFrameCutAtEveryLengthHarmsNobody) {
  start();
  const std::vector<proto::Bytes> frames{
      proto::encode(proto::Hello{}, 1),       proto::encode(proto::List{}, 2),
      proto::encode(proto::Open{"a", {}}, 3), proto::encode(proto::Requests{1, {{}}}, 4),
      proto::encode(proto::Credit{1}, 0),     proto::encode(proto::Ping{1}, 5),
      proto::encode(proto::Pong{1}, 0),       proto::encode(proto::Close{1}, 6)};
  proto::Bytes before;
  for (const proto::Bytes& frame : frames) {
    for (size_t cut = 0; cut < frame.size(); ++cut) {
      TestClient client = connect();
      client.sendBytes(before);
      client.sendBytes(std::span(frame).first(cut));
    }
    before.insert(before.end(), frame.begin(), frame.end());
  }
  expectServed();
}

TEST_F(ServerHostile, everyBodyCutAtEveryLengthIsRefusedOrTaken) {
  start();
  const proto::Bytes hello = proto::encode(proto::Hello{}, 1);
  for (const proto::Bytes& frame :
       {proto::encode(proto::Open{"a", {}}, 3), proto::encode(proto::Requests{1, {{}}}, 4),
        proto::encode(proto::Close{1}, 6)})
    for (size_t cut = proto::kFrameHeaderBytes; cut < frame.size(); ++cut) {
      auto header = proto::decodeFrameHeader(std::span(frame).first<proto::kFrameHeaderBytes>());
      header.body_bytes = static_cast<uint32_t>(cut - proto::kFrameHeaderBytes);
      TestClient client = connect();
      client.sendBytes(hello);
      client.sendBytes(proto::encodeFrameHeader(header));
      client.sendBytes(std::span(frame).subspan(proto::kFrameHeaderBytes, header.body_bytes));
      client.expect<proto::Welcome>(FrameType::kWelcome);
      EXPECT_TRUE(client.receive()) << "of type " << int{header.type} << ", cut to " << header.body_bytes;
    }
  expectServed();
}

TEST_F(ServerHostile, aClientThatShutsDownItsSendingSideIsDisconnected) {
  start();
  TestClient client = connect();
  const proto::Opened opened = client.open("a");
  client.send(requestsAll(opened.handle));
  client.socket().shutdown(asio::socket_base::shutdown_send);
  EXPECT_TRUE(endsWithin(client, 60s));
  expectServed();
}

TEST_F(ServerHostile, connectionsResetMidwayHarmNobody) {
  start();
  for (int i = 0; i < 100; ++i) {
    TestClient client = connect();
    const proto::Opened opened = client.open("a");
    client.send(proto::Credit{1ull << 40});
    client.send(requestsAll(opened.handle));
    client.socket().set_option(asio::socket_base::linger(true, 0));
  }
  expectServed();
}

TEST_F(ServerHostile, aFrameThatComesMoreSlowlyThanTheIdleDeadlineEndsItsConnection) {
  options_.idle_deadline = 200ms;
  start();
  TestClient client = connect();
  client.open("a");
  client.sendBytes(proto::encodeFrameHeader({100'000, static_cast<uint8_t>(FrameType::kRequests), 0, 1}));
  asio::error_code error;
  const std::byte crumb{0};
  const auto end = Clock::now() + 20s;
  while (!error && Clock::now() < end) {
    asio::write(client.socket(), asio::buffer(&crumb, 1), error);
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_TRUE(error) << "it is still there";
}

TEST_F(ServerHostile, aSlowReaderGetsAllItsBlobsAndDelaysNobody) {
  start();
  TestClient slow = connect();
  slow.socket().set_option(asio::socket_base::receive_buffer_size(4096));
  const proto::Opened opened = slow.open("a");
  slow.send(proto::Credit{1ull << 40});
  slow.send(requestsAll(opened.handle));
  uint64_t all = 0;
  for (uint32_t blob = 1; blob <= reader().blobCount(); ++blob) all += reader().blob(blob).bytes;
  std::array<std::byte, 4096> some;
  asio::error_code error;
  uint64_t got = 0;
  for (int i = 0; got < all && !error; ++i) {
    if (i % 40 == 0) expectServed();
    got += slow.socket().read_some(asio::buffer(some), error);
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_FALSE(error) << error.message();
}

TEST_F(ServerHostile, aFloodOfAnyFrameLetsOthersBeServed) {
  start();
  expectServedBeside(proto::encode(proto::Ping{1}, 1));
  expectServedBeside(proto::encode(proto::List{}, 1));
  expectServedBeside(proto::encode(proto::Open{"nothing", {}}, 1));
  expectServedBeside(proto::encode(proto::Credit{1}, 0));
  expectServedBeside(
      proto::encode(proto::Requests{1, {{RequestAction::kAdd, RequestClass::kVisible, 1, 9999, 1}}}, 1));
  expectServedBeside(
      proto::encode(proto::Requests{1, std::vector<proto::RequestChange>(
                                           4096, {RequestAction::kCancel, RequestClass::kVisible, 7, 0, 1})},
                    1));
  proto::Bytes optional(1000);
  const auto header = proto::encodeFrameHeader({988, 200, proto::kFlagOptional, 0});
  std::copy(header.begin(), header.end(), optional.begin());
  expectServedBeside(optional);
}

TEST_F(ServerHostile, aFloodOfConnectionsLetsOthersIn) {
  options_.max_connections = 200;
  start();
  std::atomic<bool> over = false;
  std::thread flood([&] {
    std::vector<std::unique_ptr<TestClient>> some;
    while (!over) {
      if (some.size() == 100) some.clear();
      some.push_back(std::make_unique<TestClient>(server_->port()));
    }
  });
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(isLetInSoon());
  over = true;
  flood.join();
  expectServedSoon();
}

TEST_F(ServerHostile, underTlsAHandshakeCutAtEveryLengthHarmsNobody) {
  startUnderTls();
  asio::ssl::context context(asio::ssl::context::tls_client);
  SSL* const tls = SSL_new(context.native_handle());
  SSL_set_bio(tls, BIO_new(BIO_s_mem()), BIO_new(BIO_s_mem()));
  SSL_connect(tls);
  std::vector<std::byte> hello(4096);
  hello.resize(
      static_cast<size_t>(BIO_read(SSL_get_wbio(tls), hello.data(), static_cast<int>(hello.size()))));
  SSL_free(tls);
  for (size_t cut = 0; cut <= hello.size(); ++cut) connect().sendBytes(std::span(hello).first(cut));
  expectServedUnderTls();
}

TEST_F(ServerHostile, underTlsBytesThatAreNoRecordEndTheirConnectionAlone) {
  startUnderTls();
  TlsClient client(server_->port());
  client.send(proto::Hello{});
  EXPECT_EQ(client.receive(), FrameType::kWelcome);
  asio::write(client.socket(), asio::buffer("these bytes are no record of TLS"));
  EXPECT_EQ(client.receive(), FrameType{});
  expectServedUnderTls();
}

}  // namespace
}  // namespace lode::serve
