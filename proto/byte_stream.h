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

/// A TCP connection, plain or under TLS. One coroutine may read while another writes, all on the socket's one
/// thread.
class ByteStream {
 public:
  explicit ByteStream(asio::ip::tcp::socket socket);
  /// Under TLS: a handshake comes before anything else.
  ByteStream(asio::ip::tcp::socket socket, std::shared_ptr<asio::ssl::context> tls);

  /// The server's side of the TLS handshake; nothing on a plain stream.
  /// @return false if the peer closed before it said anything.
  /// @throws Error kNetwork: why it failed, in a few words of OpenSSL's or of the system's.
  asio::awaitable<bool> acceptHandshake();
  /// The client's side: the peer must prove to be this host. Nothing on a plain stream.
  /// @param host  name or number. @throws Error kNetwork: why it does not.
  asio::awaitable<void> connectHandshake(std::string host);
  /// Whether the certificate was what a handshake of the client's side failed for.
  bool isPeerDoubted();

  /// @param error  outlives the awaitable; asio::error::eof if the peer has closed its side, under TLS with a
  /// goodbye or without one: frames tell their lengths, so that none is cut short unseen.
  asio::awaitable<size_t> readSome(asio::mutable_buffer into, asio::error_code& error);
  /// Writes all of it. Under TLS several parts are cheaper in one.
  asio::awaitable<void> write(std::span<const asio::const_buffer> parts, asio::error_code& error);
  /// Until the kernel's send buffer takes more.
  asio::awaitable<void> waitWritable(asio::error_code& error);

  asio::any_io_executor executor() { return socket().get_executor(); }
  asio::ip::tcp::socket& socket() noexcept { return tls_ ? tls_->next_layer() : *plain_; }
  bool encrypted() const noexcept { return tls_.has_value(); }

  void shutdownSend() noexcept;
  void close() noexcept;  ///< whatever is under way ends with an error

 private:
  std::shared_ptr<asio::ssl::context> context_;
  std::optional<asio::ip::tcp::socket> plain_;
  std::optional<asio::ssl::stream<asio::ip::tcp::socket>> tls_;
};

}  // namespace lode::proto
