#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <memory>
#include <span>

#include <asio/ip/tcp.hpp>

#include "proto/byte_stream.h"
#include "proto/messages.h"

namespace lode::serve {

/// Connections that were told to go and are given time to read it: closed at once with bytes unread they
/// would be reset, and lose it. They take a descriptor and nothing else. Not thread safe.
class Refusals {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr size_t kMost = 512;           ///< beyond it the oldest are closed
  static constexpr size_t kMostHandshakes = 32;  ///< of TLS at a time: each takes memory and a moment
  static constexpr Clock::duration kLinger = std::chrono::seconds(2);

  /// Says the last word, and lingers.
  void refuse(asio::ip::tcp::socket socket, std::span<const std::byte> last_word, Clock::time_point now);
  /// The same under TLS, after the handshake; with too many of those at a time nothing is said.
  void refuseUnderTls(asio::ip::tcp::socket socket, std::shared_ptr<asio::ssl::context> tls,
                      proto::Bytes last_word, Clock::time_point now);
  /// The same without lingering: there is no descriptor to spare.
  static void refuseAtOnce(asio::ip::tcp::socket socket, std::span<const std::byte> last_word);
  /// Closes those that have read it or had their time.
  void sweep(Clock::time_point now);
  size_t size() const noexcept { return lingering_.size(); }

 private:
  struct Lingering {
    std::shared_ptr<proto::ByteStream> stream;  ///< under TLS what is told runs by itself, and closes it
    Clock::time_point until;
  };
  void linger(std::shared_ptr<proto::ByteStream> stream, Clock::time_point now);
  std::deque<Lingering> lingering_;
};

}  // namespace lode::serve
