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

namespace lode::proto {

/// A TCP connection, plain or with TLS. One coroutine may read while another writes, both on the socket's
/// thread.
class ByteStream {
 public:
  explicit ByteStream(asio::ip::tcp::socket socket);
  /// Creates a stream with TLS. Call a handshake function before any other function.
  ByteStream(asio::ip::tcp::socket socket, std::shared_ptr<asio::ssl::context> tls);

  /// Performs the TLS handshake as a server. Does nothing on a plain stream.
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
  /// missing.
  asio::awaitable<size_t> readSome(asio::mutable_buffer into, asio::error_code& error);
  /// Writes all parts. With TLS, one large part costs less than several small ones.
  asio::awaitable<void> write(std::span<const asio::const_buffer> parts, asio::error_code& error);
  /// Waits until the kernel's send buffer has room.
  asio::awaitable<void> waitWritable(asio::error_code& error);

  asio::any_io_executor executor() { return socket().get_executor(); }
  asio::ip::tcp::socket& socket() noexcept { return tls_ ? tls_->next_layer() : *plain_; }
  bool encrypted() const noexcept { return tls_.has_value(); }

  void shutdownSend() noexcept;
  void close() noexcept;  ///< closes the connection; pending operations end with an error

 private:
  std::shared_ptr<asio::ssl::context> context_;
  std::optional<asio::ip::tcp::socket> plain_;
  std::optional<asio::ssl::stream<asio::ip::tcp::socket>> tls_;
};

}  // namespace lode::proto
