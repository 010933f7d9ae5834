#include "proto/websocket.h"

#include <string>

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode::proto {
namespace {

/// Returns a frame as a client sends it.
std::string frame(unsigned first_byte, const std::string& payload, unsigned length_form = 0) {
  std::string bytes{static_cast<char>(first_byte)};
  const auto put = [&](uint64_t value, int count) {
    for (int shift = 8 * (count - 1); shift >= 0; shift -= 8)
      bytes += static_cast<char>(value >> shift & 0xFF);
  };
  if (length_form == 0) length_form = payload.size() < 126 ? 1 : payload.size() < 65536 ? 2 : 8;
  put(0x80 | (length_form == 1 ? payload.size() : length_form == 2 ? 126 : 127), 1);
  if (length_form > 1) put(payload.size(), static_cast<int>(length_form));
  const std::string mask = "\x12\x34\x56\xFE";
  bytes += mask;
  for (size_t i = 0; i < payload.size(); ++i) bytes += static_cast<char>(payload[i] ^ mask[i % 4]);
  return bytes;
}

constexpr unsigned kFinalBinary = 0x82, kFirstBinary = 0x02, kMore = 0x00, kLast = 0x80, kPing = 0x89,
                   kPong = 0x8A, kClose = 0x88;

/// Decodes bytes that arrive in pieces of a size.
std::string decode(WebSocketDecoder& decoder, std::string bytes, size_t piece_bytes = 1 << 20) {
  std::string payload;
  for (size_t at = 0; at < bytes.size(); at += piece_bytes) {
    std::string piece = bytes.substr(at, piece_bytes);
    const size_t count = decoder.decode(std::as_writable_bytes(std::span(piece)));
    payload += piece.substr(0, count);
  }
  return payload;
}

std::string answersOf(WebSocketDecoder& decoder) {
  const std::vector<std::byte> answers = decoder.takeAnswers();
  return {reinterpret_cast<const char*>(answers.data()), answers.size()};
}

TEST(WebSocket, answersAKeyAsTheStandardsExample) {
  EXPECT_EQ(webSocketAccept("dGhlIHNhbXBsZSBub25jZQ=="), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
  EXPECT_TRUE(isWebSocketKey("dGhlIHNhbXBsZSBub25jZQ=="));
  for (const char* const key :
       {"", "dGhlIHNhbXBsZSBub25jZQ=", "dGhlIHNhbXBsZSBub25jZQ!=", "dGhlIHNhbXBsZSBub25 ZQ=="})
    EXPECT_FALSE(isWebSocketKey(key)) << key;
}

TEST(WebSocket, joinsMessagesThatArriveInPieces) {
  const std::string large(70000, 'x'), medium(300, 'y');
  const std::string sent = frame(kFinalBinary, "one") + frame(kFinalBinary, "") +
                           frame(kFinalBinary, medium) + frame(kFirstBinary, "two") +
                           frame(kPing, "in between") + frame(kMore, "three") + frame(kLast, large) +
                           frame(kFinalBinary, "z", 8);
  std::string payload = "one";
  payload.append(medium).append("twothree").append(large).append("z");
  for (const size_t piece_bytes : {size_t{1}, size_t{2}, size_t{7}, size_t{4096}, size_t{1} << 20}) {
    WebSocketDecoder decoder;
    EXPECT_EQ(decode(decoder, sent, piece_bytes), payload) << piece_bytes;
    EXPECT_EQ(answersOf(decoder), std::string("\x8A\x0A") + "in between");
    EXPECT_EQ(answersOf(decoder), "");
  }
}

TEST(WebSocket, answersPingAndClose) {
  WebSocketDecoder decoder;
  EXPECT_EQ(decode(decoder, frame(kPing, "") + frame(kPong, "ignored")), "");
  EXPECT_EQ(answersOf(decoder), std::string("\x8A\0", 2));
  EXPECT_FALSE(decoder.closed());
  EXPECT_EQ(decode(decoder, frame(kClose,
                                  "\x03\xE9"
                                  "bye") +
                                frame(kFinalBinary, "late")),
            "");
  EXPECT_TRUE(decoder.closed());
  EXPECT_EQ(answersOf(decoder), "\x88\x02\x03\xE9");
}

TEST(WebSocket, boundsTheAnswersToPings) {
  WebSocketDecoder decoder;
  for (int i = 0; i < 10000; ++i) decode(decoder, frame(kPing, std::string(125, 'p')));
  EXPECT_LE(decoder.answerBytes(), 4096 + 127);
}

TEST(WebSocket, refusesWhatBreaksTheStandard) {
  const std::string unmasked("\x82\x01x", 3);
  for (const std::string& bytes :
       {unmasked, frame(0xC2, "x"), frame(0xA2, "x"), frame(0x81, "text"), frame(0x83, "x"), frame(0x8B, "x"),
        frame(0x09, "x"), frame(kPing, std::string(126, 'x')), frame(kMore, "x"), frame(kLast, "x"),
        frame(kFirstBinary, "x") + frame(kFinalBinary, "x"),
        std::string("\x82\xFF\xFF\0\0\0\0\0\0\0\0\0\0\0", 14)}) {
    WebSocketDecoder decoder;
    EXPECT_THROW(decode(decoder, bytes), Error);
    EXPECT_EQ(decode(decoder, std::string(1000, 'x') + frame(kFinalBinary, "late")), "")
        << "the rest is ignored";
  }
}

TEST(WebSocket, announcesTheLengthInTheShortestForm) {
  const auto header = [](uint64_t bytes) {
    const WebSocketHeader made(WebSocketOpcode::kBinary, bytes);
    return std::string(reinterpret_cast<const char*>(made.bytes().data()), made.bytes().size());
  };
  EXPECT_EQ(header(125), "\x82\x7D");
  EXPECT_EQ(header(126), std::string("\x82\x7E\0\x7E", 4));
  EXPECT_EQ(header(65535), "\x82\x7E\xFF\xFF");
  EXPECT_EQ(header(65536), std::string("\x82\x7F\0\0\0\0\0\1\0\0", 10));
}

}  // namespace
}  // namespace lode::proto
