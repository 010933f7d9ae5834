#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <asio/awaitable.hpp>
#include <asio/buffer.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/ssl/context.hpp>
#include <asio/ssl/stream.hpp>
#include <asio/steady_timer.hpp>

#include "proto/websocket.h"

namespace lode::proto {

/// A TCP connection, plain or with TLS, or the binary messages of a WebSocket on such a connection. One
/// coroutine may read while another writes, both on the socket's thread.
class ByteStream {
 public:
  explicit ByteStream(asio::ip::tcp::socket socket);
  /// Creates a stream with TLS. Call a handshake function before any other function.
  ByteStream(asio::ip::tcp::socket socket, std::shared_ptr<asio::ssl::context> tls);

  /// Makes the stream read and write payloads of a WebSocket's binary messages, as the server. Each write is
  /// a message; reads join messages. Reading also answers Ping and Close. Call it after the handshakes of TLS
  /// and HTTP, while nothing is read or written.
  void startWebSocket();

  /// Performs the TLS handshake as a server. Does nothing on a plain stream and on a WebSocket.
  /// @return false if the peer closed without sending anything.
  /// @throws Error kNetwork with OpenSSL's or the system's reason.
  asio::awaitable<bool> acceptHandshake();
  /// Performs the TLS handshake as a client and verifies that the certificate is for `host`, a name or an
  /// address. Does nothing on a plain stream. @throws Error kNetwork.
  asio::awaitable<void> connectHandshake(std::string host);
  /// Returns true if connectHandshake() failed because of the certificate.
  bool isPeerDoubted();

  /// @param error  must outlive the awaitable. Set to asio::error::eof if the peer closed its side, even
  /// without TLS's close_notify, because the length of a frame already tells the reader whether data is
  /// missing. @throws Error kProtocol if a client breaks the rules of WebSocket.
  asio::awaitable<size_t> readSome(asio::mutable_buffer into, asio::error_code& error);
  /// Writes all parts. With TLS, one large part costs less than several small ones.
  asio::awaitable<void> write(std::span<const asio::const_buffer> parts, asio::error_code& error);
  /// Waits until the kernel's send buffer has room.
  asio::awaitable<void> waitWritable(asio::error_code& error);

  asio::any_io_executor executor() { return socket().get_executor(); }
  asio::ip::tcp::socket& socket() noexcept { return tls_ ? tls_->next_layer() : *plain_; }
  bool encrypted() const noexcept { return tls_.has_value(); }

  /// Ends the stream of written bytes. Tells a WebSocket's client first, unless a write is running.
  asio::awaitable<void> finish();
  void shutdownSend() noexcept;
  void close() noexcept;  ///< closes the connection; pending operations end with an error

 private:
  /// State of a WebSocket.
  struct WebSocket {
    explicit WebSocket(const asio::any_io_executor& executor) : unlocked(executor) {}

    WebSocketDecoder decoder;
    bool is_writing = false;      ///< a coroutine writes a message or answers
    bool is_closed = false;       ///< a Close frame was sent
    asio::steady_timer unlocked;  ///< cancelled when is_writing becomes false
  };

  asio::awaitable<size_t> readRaw(asio::mutable_buffer into, asio::error_code& error);
  template <typename Buffers>
  asio::awaitable<void> writeRaw(Buffers buffers, asio::error_code& error);
  asio::awaitable<size_t> readMessages(asio::mutable_buffer into, asio::error_code& error);
  asio::awaitable<void> writeMessage(std::span<const asio::const_buffer> parts, asio::error_code& error);
  asio::awaitable<void> answer(asio::error_code& error);

  std::shared_ptr<asio::ssl::context> context_;
  std::optional<asio::ip::tcp::socket> plain_;
  std::optional<asio::ssl::stream<asio::ip::tcp::socket>> tls_;
  std::unique_ptr<WebSocket> websocket_;  ///< null if the stream is no WebSocket
};

}  // namespace lode::proto
