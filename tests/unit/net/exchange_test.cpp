#include "client/net/exchange.h"

#include <cstddef>
#include <span>
#include <utility>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <gtest/gtest.h>

#include "proto/limits.h"

namespace lode::net {
namespace {

using asio::ip::tcp;

/// An end that answers every byte with a byte, and takes none while many answers wait.
class EchoEnd {
 public:
  bool connected() const { return true; }
  bool takesInput() const { return answers_.size() <= proto::kMaxQueuedAnswerBytes; }
  proto::Bytes takeOutgoing() { return std::exchange(answers_, {}); }
  void receive(std::span<const std::byte> bytes) {
    answers_.insert(answers_.end(), bytes.begin(), bytes.end());
    received_bytes_ += bytes.size();
  }
  size_t receivedBytes() const { return received_bytes_; }

 private:
  proto::Bytes answers_;
  size_t received_bytes_ = 0;
};

/// A transport and its peer on one loop. The peer writes without a pause, and reads only if told to.
class ExchangeTest : public testing::Test {
 protected:
  ExchangeTest() {
    acceptor_.async_accept(peer_, [](const asio::error_code& error) { ASSERT_FALSE(error); });
    while (!peer_.is_open()) loop_.run_one();
    peer_.non_blocking(true);
  }

  /// Runs both sides until the end has received `bytes` bytes. If the peer does not read, stops as soon as
  /// neither side can continue.
  void work(EchoEnd& end, size_t bytes, bool peer_reads) {
    for (int idle_rounds = 0; end.receivedBytes() < bytes;) {
      asio::error_code would_block;
      size_t moved = peer_.write_some(asio::buffer(some_), would_block);
      if (peer_reads) moved += peer_.read_some(asio::buffer(some_), would_block);
      loop_.restart();
      moved += loop_.poll();
      while (exchange(transport_, end)) continue;
      const bool is_stuck = moved == 0 && !peer_reads && !transport_.hasRoom() && !end.takesInput();
      idle_rounds = is_stuck ? idle_rounds + 1 : 0;
      if (idle_rounds == 10) return;
    }
  }

  asio::io_context loop_;
  tcp::acceptor acceptor_{loop_, tcp::endpoint(asio::ip::address_v4::loopback(), 0)};
  tcp::socket peer_{loop_};
  TcpTransport transport_{loop_, {{"127.0.0.1", acceptor_.local_endpoint().port()}}, [] {}};
  proto::Bytes some_ = proto::Bytes(1u << 20);
};

/// More than the kernel's buffers of a connection hold.
constexpr size_t kMuchBytes = 64u << 20;

TEST_F(ExchangeTest, stopsReadingFromAServerThatNeverReads) {
  EchoEnd end;
  work(end, kMuchBytes, false);
  EXPECT_LT(end.receivedBytes(), kMuchBytes);
  EXPECT_FALSE(transport_.hasRoom());
  EXPECT_FALSE(end.takesInput());
}

TEST_F(ExchangeTest, continuesWhenTheServerReads) {
  EchoEnd end;
  work(end, kMuchBytes, false);
  work(end, 2 * kMuchBytes, true);
  EXPECT_GE(end.receivedBytes(), 2 * kMuchBytes);
}

TEST_F(ExchangeTest, readsNoMoreThanTheLimitBeforeTheCallerTakesIt) {
  size_t written = 0;
  for (int idle_rounds = 0; idle_rounds < 10 && written < kMuchBytes;) {
    asio::error_code would_block;
    const size_t count = peer_.write_some(asio::buffer(some_), would_block);
    written += count;
    loop_.restart();
    idle_rounds = count + loop_.poll() == 0 ? idle_rounds + 1 : 0;
  }
  EXPECT_LT(written, kMuchBytes);
  const size_t received = transport_.takeReceived().size();
  EXPECT_GE(received, kMaxReceivedBytes);
  EXPECT_LT(received, kMaxReceivedBytes + (1u << 20));
}

/// An end that never takes input, even after the caller has taken its answers.
struct BusyEnd {
  bool connected() const { return true; }
  bool takesInput() const { return false; }
  proto::Bytes takeOutgoing() { return {}; }
  void receive(std::span<const std::byte> /*bytes*/) { ++rounds; }
  size_t rounds = 0;
};

TEST_F(ExchangeTest, returnsToItsCallerAfterALimitedNumberOfRounds) {
  BusyEnd end;
  EXPECT_TRUE(exchange(transport_, end));
  EXPECT_EQ(end.rounds, kMaxExchangeRounds);
}

/// A transport that always has received bytes, as if the server sent faster than the client reads.
struct FloodedTransport {
  bool hasRoom() const { return true; }
  void send(const proto::Bytes& /*bytes*/) {}
  proto::Bytes takeReceived() { return proto::Bytes(kMaxReceivedBytes / 4); }
};

/// An end that takes all input and answers nothing.
struct SilentEnd {
  bool connected() const { return true; }
  bool takesInput() const { return true; }
  proto::Bytes takeOutgoing() { return {}; }
  void receive(std::span<const std::byte> bytes) { received_bytes += bytes.size(); }
  size_t received_bytes = 0;
};

TEST_F(ExchangeTest, returnsToItsCallerAfterALimitedNumberOfBytes) {
  FloodedTransport transport;
  SilentEnd end;
  EXPECT_TRUE(exchange(transport, end));
  EXPECT_EQ(end.received_bytes, kMaxExchangeBytes);
}

}  // namespace
}  // namespace lode::net
