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

/// Refused connections that still read the reason: closing a socket with unread bytes would reset the
/// connection and lose the reason. Each holds a descriptor and little memory. Not thread safe.
class Refusals {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr size_t kMost = 512;           ///< at a time; one more closes the oldest
  static constexpr size_t kMostHandshakes = 32;  ///< TLS handshakes at a time; each takes memory and CPU
  static constexpr Clock::duration kLinger = std::chrono::seconds(2);

  /// Sends the frame, then waits for the client to close.
  void refuse(asio::ip::tcp::socket socket, std::span<const std::byte> last_word, Clock::time_point now);
  /// Does the same under TLS, after the handshake. Sends nothing if too many handshakes are under way.
  void refuseUnderTls(asio::ip::tcp::socket socket, std::shared_ptr<asio::ssl::context> tls,
                      proto::Bytes last_word, Clock::time_point now);
  /// Sends the frame and closes at once, for when there is no descriptor to spare.
  static void refuseAtOnce(asio::ip::tcp::socket socket, std::span<const std::byte> last_word);
  /// Closes the connections whose client has closed or whose time is over.
  void sweep(Clock::time_point now);
  size_t size() const noexcept { return lingering_.size(); }

 private:
  struct Lingering {
    std::shared_ptr<proto::ByteStream>
        stream;  ///< under TLS a coroutine sends the frame and closes the stream
    Clock::time_point until;
  };
  void linger(std::shared_ptr<proto::ByteStream> stream, Clock::time_point now);
  std::deque<Lingering> lingering_;
};

}  // namespace lode::serve
