#include "proto/byte_stream.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include <asio/error.hpp>
#include <asio/ip/address.hpp>
#include <asio/redirect_error.hpp>
#include <asio/ssl/error.hpp>
#include <asio/use_awaitable.hpp>
#include <asio/write.hpp>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509_vfy.h>

#include "common/error.h"

namespace lode::proto {

using asio::ip::tcp;

ByteStream::ByteStream(tcp::socket socket) : plain_(std::move(socket)) {}

ByteStream::ByteStream(tcp::socket socket, std::shared_ptr<asio::ssl::context> tls)
    : context_(std::move(tls)) {
  tls_.emplace(std::move(socket), *context_);
}

namespace {

bool hasClosed(const asio::error_code& error) {
  return error == asio::error::eof || error == asio::ssl::error::stream_truncated;
}

/// Returns OpenSSL's short reason without the name of OpenSSL's component, or the system's message.
std::string reasonOf(const asio::error_code& error) {
  if (hasClosed(error)) return "the other side closed it";
  const bool is_openssl = error.category() == asio::error::get_ssl_category();
  const char* reason =
      is_openssl ? ERR_reason_error_string(static_cast<unsigned long>(error.value())) : nullptr;
  return reason != nullptr ? reason : error.message();
}

}  // namespace

void ByteStream::startWebSocket() { websocket_ = std::make_unique<WebSocket>(executor()); }

asio::awaitable<bool> ByteStream::acceptHandshake() {
  if (!tls_ || websocket_) co_return true;
  asio::error_code error;
  co_await tls_->async_handshake(asio::ssl::stream_base::server,
                                 asio::redirect_error(asio::use_awaitable, error));
  if (!error) co_return true;
  if (hasClosed(error) && BIO_number_read(SSL_get_rbio(tls_->native_handle())) == 0) co_return false;
  throw Error(ErrorCode::kNetwork, reasonOf(error));
}

asio::awaitable<void> ByteStream::connectHandshake(std::string host) {
  if (!tls_) co_return;
  SSL* const native = tls_->native_handle();
  asio::error_code error;
  asio::ip::make_address(host, error);
  const bool is_name = static_cast<bool>(error);
  if (is_name) SSL_set_tlsext_host_name(native, host.c_str());
  const int checked = is_name ? SSL_set1_host(native, host.c_str())
                              : X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(native), host.c_str());
  if (checked != 1)
    throw Error(ErrorCode::kNetwork,
                "no TLS certificate can be valid for the host '" + host + "': check the host name");
  co_await tls_->async_handshake(asio::ssl::stream_base::client,
                                 asio::redirect_error(asio::use_awaitable, error));
  if (!error) co_return;
  const long verdict = SSL_get_verify_result(native);
  if (verdict != X509_V_OK)
    throw Error(ErrorCode::kNetwork, "the server's certificate is not trusted: " +
                                         std::string(X509_verify_cert_error_string(verdict)));
  throw Error(ErrorCode::kNetwork, "the TLS handshake failed: " + reasonOf(error));
}

bool ByteStream::isPeerDoubted() { return tls_ && SSL_get_verify_result(tls_->native_handle()) != X509_V_OK; }

asio::awaitable<size_t> ByteStream::readSome(asio::mutable_buffer into, asio::error_code& error) {
  return websocket_ ? readMessages(into, error) : readRaw(into, error);
}

asio::awaitable<size_t> ByteStream::readRaw(asio::mutable_buffer into, asio::error_code& error) {
  if (!tls_)
    co_return co_await plain_->async_read_some(into, asio::redirect_error(asio::use_awaitable, error));
  const size_t count = co_await tls_->async_read_some(into, asio::redirect_error(asio::use_awaitable, error));
  if (error == asio::ssl::error::stream_truncated) error = asio::error::eof;
  co_return count;
}

asio::awaitable<size_t> ByteStream::readMessages(asio::mutable_buffer into, asio::error_code& error) {
  size_t payload_bytes = 0;
  while (payload_bytes == 0) {
    if (websocket_->decoder.closed()) {
      error = asio::error::eof;
      co_return 0;
    }
    const size_t count = co_await readRaw(into, error);
    if (error) co_return 0;
    payload_bytes = websocket_->decoder.decode({static_cast<std::byte*>(into.data()), count});
    if (websocket_->decoder.answerBytes() > 0) co_await answer(error);
    if (error) co_return 0;
  }
  co_return payload_bytes;
}

/// Sends the answers to Ping and Close. If a message is being written, writeMessage() sends them after it.
asio::awaitable<void> ByteStream::answer(asio::error_code& error) {
  WebSocket& socket = *websocket_;
  if (socket.is_writing || socket.is_closed) co_return;
  socket.is_writing = true;
  while (!error && socket.decoder.answerBytes() > 0) {
    const std::vector<std::byte> answers = socket.decoder.takeAnswers();
    socket.is_closed = socket.decoder.closed();
    co_await writeRaw(std::array{asio::buffer(answers)}, error);
  }
  socket.is_writing = false;
  socket.unlocked.cancel();
}

asio::awaitable<void> ByteStream::write(std::span<const asio::const_buffer> parts, asio::error_code& error) {
  return websocket_ ? writeMessage(parts, error) : writeRaw(parts, error);
}

template <typename Buffers>
asio::awaitable<void> ByteStream::writeRaw(Buffers buffers, asio::error_code& error) {
  if (tls_)
    co_await asio::async_write(*tls_, buffers, asio::redirect_error(asio::use_awaitable, error));
  else
    co_await asio::async_write(*plain_, buffers, asio::redirect_error(asio::use_awaitable, error));
}

asio::awaitable<void> ByteStream::writeMessage(std::span<const asio::const_buffer> parts,
                                               asio::error_code& error) {
  WebSocket& socket = *websocket_;
  while (socket.is_writing) {
    asio::error_code ignored;
    socket.unlocked.expires_at(asio::steady_timer::time_point::max());
    co_await socket.unlocked.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
  }
  if (socket.is_closed) {
    error = asio::error::broken_pipe;
    co_return;
  }
  const size_t bytes = asio::buffer_size(parts);
  const WebSocketHeader header(WebSocketOpcode::kBinary, bytes);
  std::vector<asio::const_buffer> buffers{asio::buffer(header.bytes().data(), header.bytes().size())};
  buffers.insert(buffers.end(), parts.begin(), parts.end());
  socket.is_writing = true;
  co_await writeRaw(std::move(buffers), error);
  socket.is_writing = false;
  socket.unlocked.cancel();
  if (!error && socket.decoder.answerBytes() > 0) co_await answer(error);
}

asio::awaitable<void> ByteStream::finish() {
  if (websocket_ && !websocket_->is_writing && !websocket_->is_closed) {
    websocket_->is_writing = websocket_->is_closed = true;
    constexpr std::array kStatus{std::byte{kWebSocketNormalClosure >> 8},
                                 std::byte{kWebSocketNormalClosure & 0xFF}};
    const WebSocketHeader header(WebSocketOpcode::kClose, kStatus.size());
    asio::error_code ignored;
    co_await writeRaw(std::array{asio::buffer(header.bytes().data(), header.bytes().size()),
                                 asio::const_buffer(kStatus.data(), kStatus.size())},
                      ignored);
    websocket_->is_writing = false;
  }
  shutdownSend();
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
