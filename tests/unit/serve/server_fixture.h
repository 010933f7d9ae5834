#pragma once

#include <memory>
#include <optional>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "proto/limits.h"
#include "server/serve/server.h"
#include "server/store/reader.h"
#include "tests/unit/serve/small_store.h"
#include "tests/unit/serve/test_client.h"

namespace lode::serve::test {

using namespace std::chrono_literals;
using proto::FrameType;
using proto::RequestAction;
using proto::RequestClass;
using proto::WireError;

/// A server over loopback with the models "a" and "b".
class ServerTest : public testing::Test {
 protected:
  ServerTest() {
    writeSmallStore(store_, 1);
    writeSmallStore(folder_.path() / "b.lode", 2);
    options_.stores = {folder_.path()};
    options_.listen = "127.0.0.1:0";
    options_.threads = 2;
    options_.check_stores_every = 0ms;
    options_.log.descriptor = quiet_;
  }
  ~ServerTest() override {
    stop();
    server_.reset();
    ::close(quiet_);
  }

  void start() {
    server_.emplace(options_);
    thread_ = std::thread([this] { server_->run(); });
  }
  void stop() {
    if (server_) server_->stop();
    if (thread_.joinable()) thread_.join();
  }
  TestClient connect() { return TestClient(server_->port()); }

  proto::Requests requestsAll(uint32_t handle) const {
    proto::Requests requests{handle, {}};
    for (uint32_t blob = 1; blob <= reader().blobCount(); ++blob)
      requests.changes.push_back(
          {RequestAction::kAdd, RequestClass::kVisible, blob, blob, static_cast<float>(blob)});
    return requests;
  }
  /// Connects repeatedly until the server has noticed that earlier clients ended, and sends Welcome. @return
  /// nothing if the server never sends Welcome.
  std::unique_ptr<TestClient> letInSoon() {
    const auto end = std::chrono::steady_clock::now() + 20s;
    while (std::chrono::steady_clock::now() < end) {
      auto client = std::make_unique<TestClient>(server_->port());
      client->send(proto::Hello{});
      const auto answer = client->receive();
      if (answer && answer->is(FrameType::kWelcome)) return client;
    }
    return nullptr;
  }
  bool isLetInSoon() { return letInSoon() != nullptr; }
  void expectAllBlobs(TestClient& client, const proto::Opened& opened) {
    client.blobs(2);
    client.send(requestsAll(opened.handle));
    const auto blobs = client.blobs(reader().blobCount());
    ASSERT_EQ(blobs.size(), reader().blobCount());
    for (const auto& [request, bytes] : blobs) EXPECT_EQ(bytes, reader().readBlob(request)) << request;
  }
  /// Connects a client that opens "a" and receives all of its blobs.
  void expectServed() {
    TestClient client = connect();
    expectAllBlobs(client, client.open("a"));
  }
  /// Like expectServed(), but waits until the server has noticed that other clients ended.
  void expectServedSoon() {
    const auto client = letInSoon();
    ASSERT_TRUE(client);
    client->send(proto::Open{"a", {}}, 2);
    expectAllBlobs(*client, client->expect<proto::Opened>(FrameType::kOpened));
  }
  const store::Reader& reader() const {
    if (!reader_) reader_.emplace(store_);
    return *reader_;
  }

  const int quiet_ = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  WorkFolder folder_;
  const std::filesystem::path store_ = folder_.path() / "a.lode";
  mutable std::optional<store::Reader> reader_;
  ServeOptions options_;
  std::optional<Server> server_;
  std::thread thread_;
};

}  // namespace lode::serve::test
