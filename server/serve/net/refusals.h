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

/// Refused connections that stay open, for at most kLinger, until their clients have read the reason. Closing
/// a socket with unread bytes would reset the connection, and the client would lose the reason. Each refused
/// connection needs a descriptor and little memory. Not thread safe.
class Refusals {
 public:
  using Clock = std::chrono::steady_clock;
  /// Largest number of connections at a time; a further refusal closes the oldest connection.
  static constexpr size_t kMost = 512;
  /// Largest number of TLS handshakes at a time. The number is small because handshakes need memory and CPU
  /// time.
  static constexpr size_t kMostHandshakes = 32;
  static constexpr Clock::duration kLinger = std::chrono::seconds(2);

  /// Sends the frame, then waits until the client closes the connection.
  void refuse(asio::ip::tcp::socket socket, std::span<const std::byte> last_word, Clock::time_point now);
  /// Like refuse(), but sends the frame under TLS after the handshake. Sends nothing if kMostHandshakes are
  /// under way.
  void refuseUnderTls(asio::ip::tcp::socket socket, std::shared_ptr<asio::ssl::context> tls,
                      proto::Bytes last_word, Clock::time_point now);
  /// Sends the frame and closes the connection at once. Used if no descriptor can be spared.
  static void refuseAtOnce(asio::ip::tcp::socket socket, std::span<const std::byte> last_word);
  /// Closes each connection that the client has closed or whose time is over.
  void sweep(Clock::time_point now);
  size_t size() const noexcept { return lingering_.size(); }

 private:
  struct Lingering {
    /// The connection. With TLS, a coroutine sends the frame and closes the stream.
    std::shared_ptr<proto::ByteStream> stream;
    Clock::time_point until;
  };
  void linger(std::shared_ptr<proto::ByteStream> stream, Clock::time_point now);
  std::deque<Lingering> lingering_;
};

}  // namespace lode::serve
