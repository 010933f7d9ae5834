#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>
#include <gtest/gtest.h>
#include <poll.h>

#include "proto/frame.h"
#include "proto/messages.h"

namespace lode::serve::test {

struct Received {
  proto::FrameHeader header;
  proto::Bytes body;
  bool is(proto::FrameType type) const { return header.type == static_cast<uint8_t>(type); }
};

/// A blocking client for tests.
class TestClient {
 public:
  /// @param from  source address of the connection.
  explicit TestClient(uint16_t port, asio::ip::address_v4 from = asio::ip::address_v4::loopback())
      : socket_(context_, asio::ip::tcp::endpoint(from, 0)) {
    socket_.connect({asio::ip::address_v4::loopback(), port});
    socket_.set_option(asio::ip::tcp::no_delay(true));
  }

  void sendBytes(std::span<const std::byte> bytes) {
    asio::error_code ignored;  // the server may have closed; the test reads its answer
    asio::write(socket_, asio::buffer(bytes.data(), bytes.size()), ignored);
  }
  void sendText(std::string_view text) { sendBytes(std::as_bytes(std::span(text))); }
  template <typename Message>
  void send(const Message& message, uint32_t call = 0) {
    sendBytes(proto::encode(message, call));
  }

  /// @return nothing at the end of the connection or after a timeout.
  std::optional<Received> receive() {
    pollfd waiting{socket_.native_handle(), POLLIN, 0};
    if (poll(&waiting, 1, 30'000) != 1) return {};
    std::array<std::byte, proto::kFrameHeaderBytes> head;
    asio::error_code error;
    asio::read(socket_, asio::buffer(head), error);
    if (error) return {};
    Received frame{proto::decodeFrameHeader(head), {}};
    frame.body.resize(frame.header.body_bytes);
    asio::read(socket_, asio::buffer(frame.body), error);
    if (error) return {};
    return frame;
  }
  /// Returns true if a frame or the end of the connection has come.
  bool hasReceived() {
    pollfd waiting{socket_.native_handle(), POLLIN, 0};
    return poll(&waiting, 1, 0) == 1;
  }
  template <typename Message>
  Message expect(proto::FrameType type) {
    const auto frame = receive();
    if (!frame || !frame->is(type)) {
      ADD_FAILURE() << "expected a frame of type " << proto::frameName(static_cast<uint8_t>(type)) << ", got "
                    << nameOf(frame);
      return {};
    }
    return proto::decode<Message>(frame->body);
  }
  void expectErrorAndEnd(proto::WireError code) {
    const auto error = expect<proto::ErrorMessage>(proto::FrameType::kError);
    EXPECT_EQ(error.code, code) << error.message;
    EXPECT_TRUE(error.closes);
    EXPECT_FALSE(receive()) << "the connection goes on";
  }

  /// Sends Hello and Open. @return the answer to Open.
  proto::Opened open(const std::string& model) {
    send(proto::Hello{proto::kProtocolVersion, proto::kProtocolVersion, 0, "", "test"}, 1);
    send(proto::Open{model, {}}, 2);
    expect<proto::Welcome>(proto::FrameType::kWelcome);
    return expect<proto::Opened>(proto::FrameType::kOpened);
  }

  /// Receives Blob frames and grants credit until `count` blobs are complete. @return the blobs in order.
  std::vector<std::pair<uint32_t, proto::Bytes>> blobs(size_t count) {
    std::vector<std::pair<uint32_t, proto::Bytes>> complete;
    std::map<uint32_t, proto::Bytes> parts;
    while (complete.size() < count) {
      const auto frame = receive();
      if (!frame || !frame->is(proto::FrameType::kBlob)) {
        ADD_FAILURE() << "no Blob frame but " << nameOf(frame);
        break;
      }
      received_bytes_ += frame->body.size();
      send(proto::Credit{received_bytes_ + (64u << 10)});
      const proto::BlobChunk chunk = proto::decodeBlobChunk(frame->body);
      proto::Bytes& blob = parts[chunk.header.request];
      EXPECT_EQ(chunk.header.offset_bytes, blob.size());
      blob.insert(blob.end(), chunk.bytes.begin(), chunk.bytes.end());
      if (blob.size() < chunk.header.total_bytes) continue;
      complete.emplace_back(chunk.header.request, std::move(blob));
      parts.erase(chunk.header.request);
    }
    return complete;
  }

  asio::ip::tcp::socket& socket() { return socket_; }

 private:
  /// Describes a frame for failure messages; for an Error, its message.
  static std::string nameOf(const std::optional<Received>& frame) {
    if (!frame) return "the end";
    const std::string name(proto::frameName(frame->header.type));
    if (!frame->is(proto::FrameType::kError)) return name;
    return name + ": " + proto::decode<proto::ErrorMessage>(frame->body).message;
  }

  asio::io_context context_;
  asio::ip::tcp::socket socket_;
  uint64_t received_bytes_ = 0;
};

}  // namespace lode::serve::test
