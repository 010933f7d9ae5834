#include "proto/byte_stream.h"

#include <string>
#include <utility>

#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>
#include <asio/write.hpp>

#include "common/error.h"

namespace lode::proto {

using asio::ip::tcp;

ByteStream::ByteStream(tcp::socket socket) : plain_(std::move(socket)) {}

ByteStream::ByteStream(tcp::socket socket, std::shared_ptr<asio::ssl::context> tls)
    : context_(std::move(tls)) {
  tls_.emplace(std::move(socket), *context_);
}

asio::awaitable<void> ByteStream::handshake() {
  if (!tls_) co_return;
  asio::error_code error;
  co_await tls_->async_handshake(asio::ssl::stream_base::server,
                                 asio::redirect_error(asio::use_awaitable, error));
  if (error) throw Error(ErrorCode::kNetwork, "the TLS handshake failed: " + error.message());
}

asio::awaitable<size_t> ByteStream::readSome(asio::mutable_buffer into, asio::error_code& error) {
  if (tls_) return tls_->async_read_some(into, asio::redirect_error(asio::use_awaitable, error));
  return plain_->async_read_some(into, asio::redirect_error(asio::use_awaitable, error));
}

asio::awaitable<void> ByteStream::write(std::span<const asio::const_buffer> parts, asio::error_code& error) {
  if (tls_)
    co_await asio::async_write(*tls_, parts, asio::redirect_error(asio::use_awaitable, error));
  else
    co_await asio::async_write(*plain_, parts, asio::redirect_error(asio::use_awaitable, error));
}

asio::awaitable<void> ByteStream::waitWritable(asio::error_code& error) {
  return socket().async_wait(tcp::socket::wait_write, asio::redirect_error(asio::use_awaitable, error));
}

void ByteStream::shutdownSend() noexcept {
  asio::error_code ignored;
  socket().shutdown(tcp::socket::shutdown_send, ignored);
}

void ByteStream::close() noexcept {
  asio::error_code ignored;
  socket().close(ignored);
}

}  // namespace lode::proto
