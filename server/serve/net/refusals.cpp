#include "server/serve/net/refusals.h"

#include <algorithm>
#include <array>
#include <utility>

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>

namespace lode::serve {

namespace {

using asio::ip::tcp;

/// Discards received bytes. @return true if the peer has closed its side or the connection is broken.
bool drop(tcp::socket& socket) {
  std::array<std::byte, 4096> room;
  asio::error_code error;
  for (int i = 0; i < 16; ++i) {  // the limit keeps a flood of bytes from occupying the thread
    socket.read_some(asio::buffer(room), error);
    if (error) break;
  }
  return error && error != asio::error::would_block;
}

void say(tcp::socket& socket, std::span<const std::byte> last_word) {
  asio::error_code ignored;
  socket.non_blocking(true, ignored);
  // Does not block: the frame fits the send buffer of a new socket.
  socket.write_some(asio::buffer(last_word.data(), last_word.size()), ignored);
  socket.shutdown(tcp::socket::shutdown_send, ignored);
}

/// Sends the frame after the TLS handshake. Runs until the client or sweep() closes the stream.
asio::awaitable<void> tell(std::shared_ptr<proto::ByteStream> stream, proto::Bytes last_word) {
  try {
    const bool is_there = co_await stream->acceptHandshake();
    asio::error_code error;
    const std::array parts{asio::const_buffer(last_word.data(), last_word.size())};
    co_await stream->write(parts, error);
    stream->shutdownSend();
    std::array<std::byte, 1024> dropped;
    while (is_there && !error) co_await stream->readSome(asio::buffer(dropped), error);
  } catch (const std::exception&) {  // the client does not speak TLS, or memory ran out
  }
  stream->close();
}

}  // namespace

void Refusals::linger(std::shared_ptr<proto::ByteStream> stream, Clock::time_point now) {
  if (lingering_.size() >= kMost) {
    lingering_.front().stream->close();
    lingering_.pop_front();
  }
  lingering_.push_back({std::move(stream), now + kLinger});
}

void Refusals::refuse(tcp::socket socket, std::span<const std::byte> last_word, Clock::time_point now) {
  say(socket, last_word);
  linger(std::make_shared<proto::ByteStream>(std::move(socket)), now);
}

void Refusals::refuseUnderTls(tcp::socket socket, std::shared_ptr<asio::ssl::context> tls,
                              proto::Bytes last_word, Clock::time_point now) {
  const auto shaking =
      std::ranges::count_if(lingering_, [](const Lingering& refused) { return refused.stream->encrypted(); });
  if (static_cast<size_t>(shaking) >= kMostHandshakes) return refuseAtOnce(std::move(socket), {});
  const auto stream = std::make_shared<proto::ByteStream>(std::move(socket), std::move(tls));
  linger(stream, now);
  asio::co_spawn(
      stream->executor(),
      [stream, word = std::move(last_word)]() mutable { return tell(stream, std::move(word)); },
      asio::detached);
}

void Refusals::refuseAtOnce(tcp::socket socket, std::span<const std::byte> last_word) {
  say(socket, last_word);
  drop(socket);
}

void Refusals::sweep(Clock::time_point now) {
  std::erase_if(lingering_, [&](Lingering& refused) {
    proto::ByteStream& stream = *refused.stream;
    const bool gone = !stream.socket().is_open() || (!stream.encrypted() && drop(stream.socket()));
    if (!gone && now < refused.until) return false;
    stream.close();
    return true;
  });
}

}  // namespace lode::serve
