#include "proto/frame_stream.h"

#include <exception>
#include <functional>
#include <optional>

#include <asio/co_spawn.hpp>
#include <asio/io_context.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>
#include <gtest/gtest.h>

#include "common/error.h"
#include "proto/messages.h"

namespace lode::proto {
namespace {

using asio::ip::tcp;

/// Two ends of a connection over loopback, on one event loop that the test runs.
class FrameStreamTest : public testing::Test {
 protected:
  FrameStreamTest() {
    tcp::acceptor acceptor(context_, {asio::ip::address_v4::loopback(), 0});
    peer_.connect(acceptor.local_endpoint());
    stream_.emplace(ByteStream(acceptor.accept()), 64);
  }

  /// Runs a coroutine to its end. @return the Error it ended with.
  std::optional<Error> run(std::function<asio::awaitable<void>()> body) {
    std::optional<Error> failure;
    asio::co_spawn(context_, std::move(body), [&](const std::exception_ptr& thrown) {
      try {
        if (thrown) std::rethrow_exception(thrown);
      } catch (const Error& error) {
        failure = error;
      }
    });
    context_.restart();
    context_.run();
    return failure;
  }

  void send(std::span<const std::byte> bytes) {
    asio::write(peer_, asio::buffer(bytes.data(), bytes.size()));
  }

  asio::io_context context_;
  tcp::socket peer_{context_};
  std::optional<FrameStream> stream_;
};

TEST_F(FrameStreamTest, readsFramesSentInOnePieceOneByOne) {
  Bytes all = encode(Ping{1}, 10);
  const Bytes second = encode(Hello{1, 1, 0, "", std::string(500, 'x')}, 11);
  const Bytes third = encode(Ping{3}, 12);
  all.insert(all.end(), second.begin(), second.end());
  all.insert(all.end(), third.begin(), third.end());
  send(all);
  const auto failure = run([&]() -> asio::awaitable<void> {
    Frame frame;
    EXPECT_TRUE(co_await stream_->read(frame));
    EXPECT_EQ(decode<Ping>(frame.body), Ping{1});
    EXPECT_EQ(frame.header.call, 10u);
    EXPECT_TRUE(co_await stream_->read(frame));
    EXPECT_EQ(decode<Hello>(frame.body).program.size(), 500u);
    EXPECT_TRUE(co_await stream_->read(frame));
    EXPECT_EQ(decode<Ping>(frame.body), Ping{3});
  });
  EXPECT_FALSE(failure);
}

TEST_F(FrameStreamTest, writesSeveralPartsAsOneRunOfBytes) {
  const Bytes first = encode(Ping{1}, 1), second = encode(Pong{2}, 2);
  EXPECT_FALSE(run([&]() -> asio::awaitable<void> {
    const std::array parts{asio::buffer(first), asio::buffer(second)};
    co_await stream_->write(parts);
    co_await stream_->write(std::span(parts).first(1));
  }));
  Bytes got(2 * first.size() + second.size());
  asio::read(peer_, asio::buffer(got));
  Bytes expected = first;
  expected.insert(expected.end(), second.begin(), second.end());
  expected.insert(expected.end(), first.begin(), first.end());
  EXPECT_EQ(got, expected);
}

TEST_F(FrameStreamTest, anEndBetweenFramesIsNoError) {
  send(encode(Ping{1}, 1));
  peer_.close();
  EXPECT_FALSE(run([&]() -> asio::awaitable<void> {
    Frame frame;
    EXPECT_TRUE(co_await stream_->read(frame));
    EXPECT_FALSE(co_await stream_->read(frame));
  }));
}

TEST_F(FrameStreamTest, anEndInTheMiddleOfAFrameIsANetworkError) {
  const Bytes frame_bytes = encode(Hello{1, 1, 0, "", std::string(500, 'x')}, 1);
  for (const size_t cut : {size_t{5}, size_t{kFrameHeaderBytes}, size_t{100}, frame_bytes.size() - 1}) {
    tcp::acceptor acceptor(context_, {asio::ip::address_v4::loopback(), 0});
    peer_ = tcp::socket(context_);
    peer_.connect(acceptor.local_endpoint());
    stream_.emplace(ByteStream(acceptor.accept()), 64);
    send(std::span(frame_bytes).first(cut));
    peer_.close();
    const auto failure = run([&]() -> asio::awaitable<void> {
      Frame frame;
      co_await stream_->read(frame);
    });
    ASSERT_TRUE(failure) << cut;
    EXPECT_EQ(failure->code(), ErrorCode::kNetwork) << cut;
  }
}

TEST_F(FrameStreamTest, aBodyAboveTheLimitIsRefusedBeforeItsMemoryIsTaken) {
  send(encodeFrameHeader({kMaxFrameBodyBytes + 1, 1, 0, 0}));
  Frame frame;
  const auto failure = run([&]() -> asio::awaitable<void> { co_await stream_->read(frame); });
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->code(), ErrorCode::kLimit);
  EXPECT_EQ(frame.body.capacity(), 0u);
}

TEST_F(FrameStreamTest, theCallersOwnLimitIsKeptToo) {
  send(encodeFrameHeader({1001, 1, 0, 0}));
  Frame frame;
  const auto failure = run([&]() -> asio::awaitable<void> { co_await stream_->read(frame, 1000); });
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->code(), ErrorCode::kLimit);
  EXPECT_EQ(frame.body.capacity(), 0u);
}

TEST_F(FrameStreamTest, aBodyTakesMemoryAsItsBytesCome) {
  send(encodeFrameHeader({kMaxFrameBodyBytes, 1, 0, 0}));
  send(Bytes(100));
  peer_.close();
  Frame frame;
  EXPECT_TRUE(run([&]() -> asio::awaitable<void> { co_await stream_->read(frame); }));
  EXPECT_LE(frame.body.capacity(), 4096u);
}

TEST_F(FrameStreamTest, growsABodyOnlyWithinTheMemoryBudget) {
  tcp::acceptor acceptor(context_, {asio::ip::address_v4::loopback(), 0});
  peer_ = tcp::socket(context_);
  peer_.connect(acceptor.local_endpoint());
  size_t room = 12'000;
  stream_.emplace(ByteStream(acceptor.accept()), 64, [&](size_t more) {
    if (more > room) return false;
    room -= more;
    return true;
  });
  send(encodeFrameHeader({50'000, 1, 0, 0}));
  send(Bytes(50'000));
  Frame frame;
  const auto failure = run([&]() -> asio::awaitable<void> { co_await stream_->read(frame); });
  ASSERT_TRUE(failure);
  EXPECT_EQ(failure->code(), ErrorCode::kLimit);
  EXPECT_LE(frame.body.capacity(), 16'384u);
}

TEST_F(FrameStreamTest, bytesThatAreNoFrameAreAProtocolError) {
  const std::string http = "GET / HTTP/1.1\r\nHost: x\r\n\r\n";
  send(std::as_bytes(std::span(http)));
  const auto failure = run([&]() -> asio::awaitable<void> {
    Frame frame;
    co_await stream_->read(frame);
  });
  ASSERT_TRUE(failure);
  EXPECT_TRUE(failure->code() == ErrorCode::kProtocol || failure->code() == ErrorCode::kLimit);
}

}  // namespace
}  // namespace lode::proto
