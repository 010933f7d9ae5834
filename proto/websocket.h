#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lode::proto {

/// Returns the value of Sec-WebSocket-Accept for a client's key (RFC 6455, 4.2.2). Thread safe.
std::string webSocketAccept(std::string_view key);

/// Returns true if a key is the base64 form of 16 bytes. Thread safe.
bool isWebSocketKey(std::string_view key) noexcept;

enum class WebSocketOpcode : uint8_t {
  kContinuation = 0,
  kText = 1,
  kBinary = 2,
  kClose = 8,
  kPing = 9,
  kPong = 10,
};

constexpr size_t kMaxWebSocketControlBytes = 125;  ///< payload of Close, Ping and Pong
constexpr uint16_t kWebSocketNormalClosure = 1000;

/// Header of a frame that a server sends, which is a whole message.
class WebSocketHeader {
 public:
  WebSocketHeader(WebSocketOpcode opcode, uint64_t payload_bytes) noexcept;
  std::span<const std::byte> bytes() const noexcept { return std::span(bytes_).first(size_); }

 private:
  std::array<std::byte, 10> bytes_{};
  size_t size_ = 0;
};

/// Decodes the frames of a client as they arrive. Joins the payloads of all binary messages to one stream of
/// bytes, so that messages and frames can begin and end anywhere and have any size. Uses constant memory. Not
/// thread safe.
class WebSocketDecoder {
 public:
  /// Decodes bytes in place. @param bytes  received bytes; the start is replaced by the payload of binary
  /// messages, which is never longer.
  /// @return number of bytes of payload.
  /// @throws Error kProtocol if the bytes break RFC 6455, or belong to a text message. All later bytes are
  /// ignored.
  size_t decode(std::span<std::byte> bytes);

  /// Moves out the frames that answer Ping and Close, in order.
  std::vector<std::byte> takeAnswers() { return std::exchange(answers_, {}); }
  /// Returns true after a Close frame. Bytes after the frame are ignored.
  bool closed() const noexcept { return closed_; }
  /// Returns the size of the answers that takeAnswers() would return.
  size_t answerBytes() const noexcept { return answers_.size(); }

 private:
  size_t decodeFrames(std::span<std::byte> bytes);
  void beginFrame();
  void checkHeader();
  void endControlFrame();

  std::array<std::byte, 14> header_{};
  size_t header_bytes_ = 0;     ///< bytes of the header that have arrived
  size_t needed_bytes_ = 2;     ///< size of the header as far as it is known
  uint64_t payload_left_ = 0;   ///< bytes of the frame's payload that have not arrived
  uint64_t payload_place_ = 0;  ///< number of payload bytes of the frame that have been unmasked
  std::array<std::byte, 4> mask_{};
  WebSocketOpcode opcode_ = WebSocketOpcode::kBinary;
  bool in_payload_ = false;
  bool in_message_ = false;  ///< a binary message has begun, and its last frame has not arrived
  bool closed_ = false;
  bool failed_ = false;                                         ///< decode() has thrown an exception
  std::array<std::byte, kMaxWebSocketControlBytes> control_{};  ///< payload of a control frame
  size_t control_bytes_ = 0;
  std::vector<std::byte> answers_;
};

}  // namespace lode::proto
