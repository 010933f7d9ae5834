#include "server/serve/server.h"

#include <thread>

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/unit/serve/server_fixture.h"

namespace lode::serve {
namespace {

using namespace test;

TEST_F(ServerTest, reportsItsAddressAndItsModels) {
  start();
  EXPECT_NE(server_->port(), 0);
  EXPECT_EQ(server_->address(), "127.0.0.1:" + std::to_string(server_->port()));
  EXPECT_EQ(server_->models(), (std::vector<std::string>{"a", "b"}));
}

TEST_F(ServerTest, sendsTheFirstBlobsAfterOpenUnrequested) {
  start();
  TestClient client = connect();
  const proto::Opened opened = client.open("a");
  EXPECT_EQ(opened.summary, reader().summary());
  const auto blobs = client.blobs(2);
  ASSERT_EQ(blobs.size(), 2u);
  EXPECT_EQ(blobs[0], std::pair(0u, reader().readBlob(opened.summary.root_page.number)));
  EXPECT_EQ(blobs[1], std::pair(0u, reader().readBlob(reader().find(kRootKey)->lods.back().payload.number)));
}

TEST_F(ServerTest, everyBlobArrivesAsItIsInTheStore) {
  start();
  expectServed();
}

TEST_F(ServerTest, framesMayComeByteByByte) {
  start();
  TestClient client = connect();
  client.socket().set_option(asio::ip::tcp::no_delay(true));
  for (const std::byte byte : proto::encode(proto::Hello{}, 1)) client.sendBytes({&byte, 1});
  client.expect<proto::Welcome>(FrameType::kWelcome);
}

TEST_F(ServerTest, pingIsAnsweredWhileTheWindowIsShut) {
  start();
  TestClient client = connect();
  const proto::Opened opened = client.open("a");
  client.send(requestsAll(opened.handle));
  client.send(proto::Ping{5});
  uint64_t body_bytes = 0;
  while (const auto frame = client.receive()) {
    if (frame->is(FrameType::kPong)) break;
    body_bytes += frame->body.size();
  }
  client.send(proto::Ping{6});
  while (const auto frame = client.receive()) {
    if (frame->is(FrameType::kPong)) break;
    body_bytes += frame->body.size();
  }
  EXPECT_LE(body_bytes, proto::kInitialWindowBytes);
}

TEST_F(ServerTest, servesOthersBesideAClientThatDoesNotRead) {
  options_.threads = 1;
  start();
  TestClient slow = connect();
  slow.send(proto::Hello{});
  slow.send(proto::Open{"b", {}});
  slow.send(proto::Credit{1ull << 40});
  proto::Requests requests{1, {}};
  for (uint32_t i = 0; i < 4000; ++i)
    requests.changes.push_back({RequestAction::kAdd, RequestClass::kVisible, i + 1, i % 10 + 1, 1});
  slow.send(requests);
  expectServed();
  expectServed();
}

TEST_F(ServerTest, appliesBackPressureToAClientThatNeverReads) {
  options_.threads = 1;
  options_.write_deadline = 500ms;
  start();
  TestClient flood = connect();
  flood.send(proto::Hello{});
  proto::Bytes many;
  for (int i = 0; i < 1000; ++i) {
    const proto::Bytes ping = proto::encode(proto::List{}, 0);
    many.insert(many.end(), ping.begin(), ping.end());
  }
  // The server stops reading while its answers are unread, and closes at last: the writes fail.
  asio::error_code error;
  size_t sent = 0;
  while (!error && sent < (1u << 30)) sent += asio::write(flood.socket(), asio::buffer(many), error);
  EXPECT_TRUE(error);
  EXPECT_LT(sent, 1u << 30);
  expectServed();
}

TEST_F(ServerTest, manyClientsAreServedAtOnce) {
  start();
  std::vector<std::thread> clients;
  reader();
  for (int i = 0; i < 12; ++i) clients.emplace_back([this] { expectServed(); });
  for (std::thread& client : clients) client.join();
}

TEST_F(ServerTest, refusesConnectionsAboveTheLimitWithAnError) {
  options_.max_connections = 2;
  start();
  std::optional<TestClient> first(std::in_place, server_->port());
  TestClient second = connect();
  first->open("a");
  second.open("a");
  connect().expectErrorAndEnd(WireError::kLimit);
  first.reset();
  while (true) {  // wait until the server has seen the end of the first
    TestClient third = connect();
    third.send(proto::Hello{});
    const auto answer = third.receive();
    ASSERT_TRUE(answer);
    if (answer->is(FrameType::kWelcome)) break;
  }
}

TEST_F(ServerTest, answersAnInvalidFrameAndCloses) {
  start();
  TestClient http = connect();
  http.sendText("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const auto answer = http.expect<proto::ErrorMessage>(FrameType::kError);
  EXPECT_TRUE(answer.closes);
  EXPECT_FALSE(http.receive());
}

TEST_F(ServerTest, aMalformedBodyIsAnsweredAndTheConnectionCloses) {
  start();
  TestClient client = connect();
  client.send(proto::Hello{});
  client.expect<proto::Welcome>(FrameType::kWelcome);
  client.sendBytes(proto::encodeFrameHeader({40, static_cast<uint8_t>(FrameType::kOpen), 0, 1}));
  client.sendBytes(proto::Bytes(40, std::byte{0xEE}));
  client.sendBytes(proto::Bytes(100'000));  // further bytes must not reset the connection
  client.expectErrorAndEnd(WireError::kMalformed);
}

TEST_F(ServerTest, refusesALargeBodyBeforeHello) {
  start();
  TestClient client = connect();
  client.sendBytes(proto::encodeFrameHeader(
      {proto::kMaxHelloBodyBytes + 1, static_cast<uint8_t>(FrameType::kHello), 0, 1}));
  client.expectErrorAndEnd(WireError::kLimit);
}

TEST_F(ServerTest, aVersionThatItDoesNotSpeakIsRefused) {
  start();
  TestClient client = connect();
  client.send(proto::Hello{9, 9, 0, "", ""});
  client.expectErrorAndEnd(WireError::kVersion);
}

TEST_F(ServerTest, disconnectsAClientThatSendsNoHello) {
  options_.handshake_deadline = 40ms;
  start();
  TestClient silent = connect(), half = connect();
  half.sendText("\x10");
  EXPECT_FALSE(silent.receive());
  EXPECT_FALSE(half.receive());
}

TEST_F(ServerTest, disconnectsASilentClient) {
  options_.idle_deadline = 40ms;
  start();
  TestClient client = connect();
  client.send(proto::Hello{});
  client.expect<proto::Welcome>(FrameType::kWelcome);
  EXPECT_FALSE(client.receive());
}

TEST_F(ServerTest, aDamagedBlobEndsItsRequestAlone) {
  start();
  const uint32_t bad = reader().find(kRootKey.child(3))->lods[0].payload.number;
  test::damage(store_, reader().blob(bad).offset + 100);
  TestClient client = connect();
  const proto::Opened opened = client.open("a");
  client.blobs(2);
  client.send(proto::Requests{opened.handle,
                              {{RequestAction::kAdd, RequestClass::kVisible, 1, bad, 5},
                               {RequestAction::kAdd, RequestClass::kVisible, 2, bad + 1, 1}}});
  const auto error = client.expect<proto::ErrorMessage>(FrameType::kError);
  EXPECT_EQ(error.code, WireError::kDamagedStore);
  EXPECT_EQ(error.request, 1u);
  EXPECT_FALSE(error.closes);
  const auto blobs = client.blobs(1);
  EXPECT_EQ(blobs.at(0), std::pair(2u, reader().readBlob(bad + 1)));
}

/// Returns the bytes of all blobs, which exceed the initial window.
uint64_t bytesOfAllBlobs(const store::Reader& reader) {
  uint64_t bytes = 0;
  for (uint32_t blob = 1; blob <= reader.blobCount(); ++blob) bytes += reader.blob(blob).bytes;
  EXPECT_GT(bytes, 2 * proto::kInitialWindowBytes);
  return bytes;
}

TEST_F(ServerTest, stoppingSaysGoAwayLetsOpenRequestsEndAndCloses) {
  start();
  const uint64_t all_bytes = bytesOfAllBlobs(reader());
  TestClient client = connect();
  const proto::Opened opened = client.open("a");
  client.blobs(2);
  client.send(requestsAll(opened.handle));
  uint64_t received = 0, blob_bytes = 0;
  const auto take = [&](const Received& frame) {
    received += frame.body.size();
    blob_bytes += proto::decodeBlobChunk(frame.body).bytes.size();
  };
  const auto first = client.receive();  // the server has the requests
  ASSERT_TRUE(first && first->is(FrameType::kBlob));
  take(*first);
  server_->stop();
  auto frame = client.receive();
  for (; frame && frame->is(FrameType::kBlob); frame = client.receive()) take(*frame);
  ASSERT_TRUE(frame && frame->is(FrameType::kGoAway));
  EXPECT_LT(blob_bytes, all_bytes) << "no request was open when the server went away";
  client.expect<proto::Ping>(FrameType::kPing);
  client.send(proto::Pong{});
  client.send(proto::Credit{4 * all_bytes});
  while ((frame = client.receive())) {
    EXPECT_TRUE(frame->is(FrameType::kBlob)) << proto::frameName(frame->header.type);
    take(*frame);
  }
  EXPECT_EQ(blob_bytes, all_bytes);
  client.socket().close();
  thread_.join();
}

TEST_F(ServerTest, stoppingAnswersARequestThatCrossesGoAway) {
  start();
  TestClient client = connect();
  const proto::Opened opened = client.open("a");
  client.blobs(2);
  server_->stop();
  client.expect<proto::GoAway>(FrameType::kGoAway);
  client.expect<proto::Ping>(FrameType::kPing);
  client.send(
      proto::Requests{opened.handle, {{proto::RequestAction::kAdd, proto::RequestClass::kVisible, 1, 3, 1}}});
  client.send(proto::Pong{});
  const auto frame = client.receive();
  ASSERT_TRUE(frame && frame->is(FrameType::kBlob));
  client.socket().close();
  thread_.join();
}

TEST_F(ServerTest, stoppingWaitsForAClientThatDoesNotReadAsLongAsItsDeadlineSays) {
  options_.drain_deadline = 300ms;
  start();
  bytesOfAllBlobs(reader());
  TestClient client = connect();
  const proto::Opened opened = client.open("a");
  client.blobs(2);
  client.send(requestsAll(opened.handle));
  const auto first = client.receive();
  ASSERT_TRUE(first && first->is(FrameType::kBlob));
  const auto begin = std::chrono::steady_clock::now();
  server_->stop();
  thread_.join();
  const auto spent = std::chrono::steady_clock::now() - begin;
  EXPECT_GE(spent, options_.drain_deadline) << "its requests were given up early";
  EXPECT_LT(spent, 20s);
}

TEST_F(ServerTest, stoppedBeforeItRunsItReturnsAtOnce) {
  server_.emplace(options_);
  const auto start_time = std::chrono::steady_clock::now();
  server_->stop();
  server_->run();
  EXPECT_LT(std::chrono::steady_clock::now() - start_time, options_.drain_deadline)
      << "it waited for clients that there were not";
}

TEST_F(ServerTest, stoppedTwiceItWaitsNoLongerForItsDelay) {
  options_.drain_delay = std::chrono::hours(1);
  start();
  const auto start_time = std::chrono::steady_clock::now();
  server_->stop();
  server_->stop();
  thread_.join();
  EXPECT_LT(std::chrono::steady_clock::now() - start_time, options_.drain_delay);
}

TEST_F(ServerTest, aPortInUseIsOneLineThatNamesAddressAndRemedy) {
  start();
  ServeOptions second = options_;
  second.listen = server_->address();
  try {
    Server refused(second);
    FAIL();
  } catch (const Error& error) {
    const std::string what = error.what();
    EXPECT_EQ(error.code(), ErrorCode::kIo);
    EXPECT_NE(what.find(second.listen), std::string::npos) << what;
    EXPECT_NE(what.find("--listen"), std::string::npos) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos);
  }
}

TEST_F(ServerTest, listensBeyondLoopbackOnlyIfPublicAndInsecureAreSet) {
  options_.listen = "0.0.0.0:0";
  const auto code = [&](bool public_ok, bool insecure) -> std::optional<ErrorCode> {
    options_.public_ok = public_ok;
    options_.insecure = insecure;
    try {
      Server server(options_);
    } catch (const Error& error) {
      return error.code();
    }
    return {};
  };
  EXPECT_EQ(code(false, false), ErrorCode::kUsage);
  EXPECT_EQ(code(true, false), ErrorCode::kUsage);
  EXPECT_EQ(code(false, true), ErrorCode::kUsage);
  EXPECT_EQ(code(true, true), std::nullopt);
}

TEST_F(ServerTest, anAddressOfAnotherMachineIsRefused) {
  options_.public_ok = options_.insecure = true;
  options_.listen = "192.0.2.1:0";
  try {
    Server refused(options_);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("name an address of this machine"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace lode::serve
