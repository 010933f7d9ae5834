#include "proto/websocket.h"

#include <algorithm>

#include <openssl/evp.h>
#include <openssl/sha.h>

#include "common/error.h"

namespace lode::proto {

namespace {

constexpr unsigned kFinal = 0x80, kReserved = 0x70, kOpcode = 0x0F;  ///< first byte of a header
constexpr unsigned kMasked = 0x80, kLength = 0x7F;                   ///< second byte
constexpr unsigned kLength16 = 126, kLength64 = 127;                 ///< lengths that announce a longer field
constexpr size_t kShortHeaderBytes = 2, kMaskBytes = 4;
constexpr size_t kKeyDigits = 24;
/// Limit of the waiting answers to Ping. A client that pings faster than it reads gets no further answers.
constexpr size_t kMaxAnswerBytes = 4096;

unsigned valueOf(std::byte byte) noexcept { return std::to_integer<unsigned>(byte); }

[[noreturn]] void refuse(const char* why) {
  throw Error(ErrorCode::kProtocol, std::string("a WebSocket frame ") + why);
}

bool isControl(WebSocketOpcode opcode) noexcept { return (static_cast<unsigned>(opcode) & 8) != 0; }

}  // namespace

std::string webSocketAccept(std::string_view key) {
  const std::string text = std::string(key) + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
  std::array<unsigned char, SHA_DIGEST_LENGTH> hash{};
  SHA1(reinterpret_cast<const unsigned char*>(text.data()), text.size(), hash.data());
  std::array<unsigned char, 4 * (SHA_DIGEST_LENGTH + 2) / 3 + 1> digits{};
  const int count = EVP_EncodeBlock(digits.data(), hash.data(), static_cast<int>(hash.size()));
  return {reinterpret_cast<const char*>(digits.data()), static_cast<size_t>(count)};
}

bool isWebSocketKey(std::string_view key) noexcept {
  const auto is_digit = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '+' || c == '/';
  };
  return key.size() == kKeyDigits && key.ends_with("==") && std::ranges::all_of(key.substr(0, 22), is_digit);
}

WebSocketHeader::WebSocketHeader(WebSocketOpcode opcode, uint64_t payload_bytes) noexcept {
  const auto put = [this](uint64_t value) { bytes_[size_++] = static_cast<std::byte>(value & 0xFF); };
  put(kFinal | static_cast<unsigned>(opcode));
  if (payload_bytes < kLength16) {
    put(payload_bytes);
    return;
  }
  const bool is_short = payload_bytes <= 0xFFFF;
  put(is_short ? kLength16 : kLength64);
  for (int shift = is_short ? 8 : 56; shift >= 0; shift -= 8) put(payload_bytes >> shift);
}

size_t WebSocketDecoder::decode(std::span<std::byte> bytes) {
  if (failed_) return 0;
  try {
    return decodeFrames(bytes);
  } catch (const Error&) {
    failed_ = true;
    throw;
  }
}

size_t WebSocketDecoder::decodeFrames(std::span<std::byte> bytes) {
  size_t read = 0, written = 0;
  while (read < bytes.size() && !closed_) {
    if (!in_payload_) {
      header_[header_bytes_++] = bytes[read++];
      if (header_bytes_ == needed_bytes_) beginFrame();
      continue;
    }
    const auto count = static_cast<size_t>(std::min<uint64_t>(payload_left_, bytes.size() - read));
    std::byte* const into = isControl(opcode_) ? control_.data() + control_bytes_ : bytes.data() + written;
    for (size_t i = 0; i < count; ++i) into[i] = bytes[read + i] ^ mask_[(payload_place_ + i) % kMaskBytes];
    (isControl(opcode_) ? control_bytes_ : written) += count;
    read += count;
    payload_place_ += count;
    payload_left_ -= count;
    if (payload_left_ > 0) continue;
    in_payload_ = false;
    if (isControl(opcode_)) endControlFrame();
  }
  return written;
}

/// Handles a header whose first `needed_bytes_` bytes have arrived.
void WebSocketDecoder::beginFrame() {
  const unsigned length = valueOf(header_[1]) & kLength;
  const size_t length_bytes = length == kLength16 ? 2 : length == kLength64 ? 8 : 0;
  if (header_bytes_ == kShortHeaderBytes) {
    checkHeader();
    needed_bytes_ = kShortHeaderBytes + length_bytes + kMaskBytes;
    return;
  }
  payload_left_ = length_bytes == 0 ? length : 0;
  for (size_t i = 0; i < length_bytes; ++i)
    payload_left_ = payload_left_ << 8 | valueOf(header_[kShortHeaderBytes + i]);
  if (payload_left_ >> 63 != 0) refuse("is too long");
  std::copy_n(header_.begin() + static_cast<std::ptrdiff_t>(kShortHeaderBytes + length_bytes), kMaskBytes,
              mask_.begin());
  header_bytes_ = 0;
  needed_bytes_ = kShortHeaderBytes;
  payload_place_ = 0;
  in_payload_ = payload_left_ > 0;
  if (!in_payload_ && isControl(opcode_)) endControlFrame();
}

/// Checks the first two bytes of a header.
void WebSocketDecoder::checkHeader() {
  const unsigned first = valueOf(header_[0]), second = valueOf(header_[1]);
  const unsigned opcode = first & kOpcode;
  const bool is_final = (first & kFinal) != 0;
  if ((first & kReserved) != 0) refuse("uses an extension that was not agreed on");
  if ((second & kMasked) == 0) refuse("is not masked");
  opcode_ = static_cast<WebSocketOpcode>(opcode);
  switch (opcode_) {
    case WebSocketOpcode::kContinuation:
      if (!in_message_) refuse("continues no message");
      in_message_ = !is_final;
      return;
    case WebSocketOpcode::kBinary:
      if (in_message_) refuse("begins a message within another one");
      in_message_ = !is_final;
      return;
    case WebSocketOpcode::kText:
      refuse("belongs to a text message; send binary messages");
    case WebSocketOpcode::kClose:
    case WebSocketOpcode::kPing:
    case WebSocketOpcode::kPong:
      if (!is_final || (second & kLength) > kMaxWebSocketControlBytes) refuse("is a long control frame");
      control_bytes_ = 0;
      return;
  }
  refuse("has an unknown opcode");
}

void WebSocketDecoder::endControlFrame() {
  const auto answer = [this](WebSocketOpcode opcode, size_t bytes) {
    const WebSocketHeader header(opcode, bytes);
    answers_.insert(answers_.end(), header.bytes().begin(), header.bytes().end());
    answers_.insert(answers_.end(), control_.begin(), control_.begin() + static_cast<std::ptrdiff_t>(bytes));
  };
  if (opcode_ == WebSocketOpcode::kPing && answers_.size() < kMaxAnswerBytes)
    answer(WebSocketOpcode::kPong, control_bytes_);
  if (opcode_ == WebSocketOpcode::kClose) {
    closed_ = true;
    answer(WebSocketOpcode::kClose, control_bytes_ < 2 ? 0 : 2);  // the client's own status
  }
}

}  // namespace lode::proto
