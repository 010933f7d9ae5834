#include "proto/messages.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "common/error.h"
#include "proto/limits.h"
#include "tests/unit/proto/sample_messages.h"

namespace lode::proto {
namespace {

using test::sampleSummary;

std::span<const std::byte> bodyOf(const Bytes& frame) { return std::span(frame).subspan(kFrameHeaderBytes); }

FrameHeader headerOf(const Bytes& frame) {
  return decodeFrameHeader(std::span<const std::byte, kFrameHeaderBytes>(frame.data(), kFrameHeaderBytes));
}

template <typename Message>
Message roundTrip(const Message& message) {
  return decode<Message>(bodyOf(encode(message, 5)));
}

TEST(Messages, decodeToTheEncodedMessage) {
  test::forEachSample([](const auto& message) { EXPECT_EQ(roundTrip(message), message); });
}

TEST(Messages, decodeRequestsIntoAReusedObject) {
  Requests into{7, std::vector<RequestChange>(3)};
  const Bytes frame = encode(Requests{2, {{RequestAction::kAdd, RequestClass::kMargin, 4, 5, 1.5f}}}, 0);
  decodeInto(std::span(frame).subspan(kFrameHeaderBytes), into);
  EXPECT_EQ(into, (Requests{2, {{RequestAction::kAdd, RequestClass::kMargin, 4, 5, 1.5f}}}));
}

TEST(Messages, decodeWithEveryFieldAtItsDefault) {
  EXPECT_EQ(roundTrip(Hello{}), Hello{});
  EXPECT_EQ(roundTrip(Welcome{}), Welcome{});
  EXPECT_EQ(roundTrip(Models{}), Models{});
  EXPECT_EQ(roundTrip(Open{"a", {}}), (Open{"a", {}}));
  EXPECT_EQ(roundTrip(Requests{}), Requests{});
  EXPECT_EQ(roundTrip(Credit{}), Credit{});
  EXPECT_EQ(roundTrip(ErrorMessage{}), ErrorMessage{});
  EXPECT_EQ(roundTrip(Ping{}), Ping{});
}

TEST(Messages, decodeASummaryWithoutTextures) {
  ModelSummary summary = sampleSummary();
  summary.textures = {};
  EXPECT_EQ(roundTrip(Opened{1, summary}).summary, summary);
}

TEST(Messages, theFrameAnnouncesItsBodyTypeAndCall) {
  uint8_t type = 0;
  test::forEachSample([&](const auto& message) {
    if (++type == static_cast<uint8_t>(FrameType::kBlob)) ++type;
    const Bytes frame = encode(message, 4711);
    const auto body_bytes = static_cast<uint32_t>(frame.size() - kFrameHeaderBytes);
    EXPECT_EQ(headerOf(frame), (FrameHeader{body_bytes, type, 0, 4711}));
  });
  EXPECT_FALSE(isFrameType(type + 1)) << "sampleMessages() lacks a message";
}

/// The example exchange of docs/protocol.md, from which others write clients.
TEST(Messages, haveTheDocumentedBytes) {
  const auto hex = [](const Bytes& bytes) {
    std::string text;
    for (const std::byte byte : bytes) {
      constexpr std::string_view digits = "0123456789abcdef";
      text += digits[std::to_integer<size_t>(byte) >> 4];
      text += digits[std::to_integer<size_t>(byte) & 15];
    }
    return text;
  };
  EXPECT_EQ(hex(encode(Hello{4, 4, 0, "", "x"}, 1)),
            "380000000100000001000000"
            "1400000000000e001400040008000000"
            "0c0010000e00000004000000"
            "04000000100000000400000001000000"
            "780000000000000000000000");
  EXPECT_EQ(hex(encode(Open{"a", {}}, 2)),
            "1c0000000500000002000000"
            "0c000000000006000800040006000000040000000100000061000000");
  EXPECT_EQ(hex(encode(Requests{1, {{RequestAction::kAdd, RequestClass::kVisible, 1, 3, 2.5f}}}, 3)),
            "400000000700000003000000"
            "0c00000008000c000400080008000000010000000400000001000000"
            "1400000000000e0010000000000004000800"
            "0c000e00000001000000"
            "0300000000002040");
  EXPECT_EQ(hex(encode(Credit{105'536}, 0)),
            "180000000800000000000000"
            "0c000000000006000c00040006000000409c010000000000");
}

TEST(Messages, decodeAtAnyAddress) {
  const Bytes frame = encode(Opened{4, sampleSummary()}, 0);
  for (size_t shift = 0; shift < 16; ++shift) {
    Bytes moved(shift + frame.size());
    std::ranges::copy(frame, moved.begin() + static_cast<std::ptrdiff_t>(shift));
    const auto body = std::span(moved).subspan(shift + kFrameHeaderBytes);
    EXPECT_EQ(decode<Opened>(body).summary, sampleSummary());
  }
}

TEST(Messages, aFullBatchOfRequestsFitsInAFrame) {
  Requests requests{1, {}};
  for (uint32_t i = 1; i <= kMaxRequestsPerFrame; ++i)
    requests.changes.push_back({RequestAction::kAdd, RequestClass::kMargin, i, i, static_cast<float>(i)});
  EXPECT_EQ(roundTrip(requests), requests);
}

TEST(Messages, areNotEncodedIfADecoderWouldRefuseThem) {
  EXPECT_THROW(encode(Requests{1, std::vector<RequestChange>(kMaxRequestsPerFrame + 1)}, 0), Error);
  EXPECT_THROW(encode(Models{std::vector<ModelSummary>(kMaxListedModels + 1)}, 0), Error);
  EXPECT_THROW(encode(Open{std::string(256, 'x'), {}}, 0), Error);
  EXPECT_THROW(encode(Open{"line\nbreak", {}}, 0), Error);
  EXPECT_THROW(encode(Hello{1, 1, 0, std::string(kMaxTokenBytes + 1, 'x'), ""}, 0), Error);
}

TEST(Messages, encodeRefusesABodyAboveTheLimitOfAFrame) {
  const Models models{std::vector<ModelSummary>(kMaxListedModels, sampleSummary(std::string(255, 'n')))};
  EXPECT_THROW(encode(models, 0), Error);
}

TEST(Messages, textForPeopleIsCutAtACharacterAndMadePrintable) {
  const auto text = [](const std::string& message) {
    return roundTrip(ErrorMessage{WireError::kInternal, 0, false, message}).message;
  };
  EXPECT_EQ(text("two\nlines\x1b[31m"), "two?lines?[31m");
  EXPECT_EQ(text("latin \xE9"), "latin ?");
  EXPECT_EQ(text(std::string(kMaxStringBytes + 10, 'a')), std::string(kMaxStringBytes, 'a'));
  const std::string cut = text(std::string(kMaxStringBytes - 1, 'a') + "äöü");
  EXPECT_EQ(cut, std::string(kMaxStringBytes - 1, 'a'));
}

}  // namespace
}  // namespace lode::proto
