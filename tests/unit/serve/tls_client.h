#pragma once

#include <array>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/read.hpp>
#include <asio/ssl/context.hpp>
#include <asio/ssl/stream.hpp>
#include <asio/write.hpp>

#include "proto/frame.h"
#include "proto/messages.h"

namespace lode::serve::test {

/// A blocking client with TLS.
class TlsClient {
 public:
  explicit TlsClient(uint16_t port, int newest = TLS1_3_VERSION) {
    SSL_set_max_proto_version(stream_.native_handle(), newest);
    stream_.next_layer().connect({asio::ip::address_v4::loopback(), port});
    stream_.handshake(asio::ssl::stream_base::client, error_);
  }
  bool connected() const { return !error_; }
  template <typename Message>
  void send(const Message& message) {
    asio::write(stream_, asio::buffer(proto::encode(message, 0)), error_);
  }
  proto::FrameType receive() {
    std::array<std::byte, proto::kFrameHeaderBytes> head{};
    asio::read(stream_, asio::buffer(head), error_);
    if (error_) return {};
    const auto header = proto::decodeFrameHeader(head);
    proto::Bytes body(header.body_bytes);
    asio::read(stream_, asio::buffer(body), error_);
    return static_cast<proto::FrameType>(header.type);
  }
  asio::ip::tcp::socket& socket() { return stream_.next_layer(); }

 private:
  asio::io_context context_;
  asio::ssl::context tls_{asio::ssl::context::tls_client};
  asio::ssl::stream<asio::ip::tcp::socket> stream_{context_, tls_};
  asio::error_code error_;
};

}  // namespace lode::serve::test
