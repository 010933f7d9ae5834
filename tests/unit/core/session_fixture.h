#pragma once

#include <algorithm>
#include <variant>

#include <gtest/gtest.h>

#include "client/core/session/session.h"
#include "common/error.h"
#include "proto/limits.h"

namespace lode::core::fixture {

using proto::Bytes;
using proto::FrameType;

constexpr TimePoint kStart{};

struct SentFrame {
  proto::FrameHeader header;
  Bytes body;
};

inline std::vector<SentFrame> framesOf(const Bytes& bytes) {
  std::vector<SentFrame> frames;
  std::span<const std::byte> rest = bytes;
  while (!rest.empty()) {
    const auto header = proto::decodeFrameHeader(rest.first<proto::kFrameHeaderBytes>());
    const auto body = rest.subspan(proto::kFrameHeaderBytes, header.body_bytes);
    frames.push_back({header, {body.begin(), body.end()}});
    rest = rest.subspan(proto::kFrameHeaderBytes + header.body_bytes);
  }
  return frames;
}

template <typename Message>
std::vector<Message> messagesOf(const Bytes& bytes, FrameType type) {
  std::vector<Message> messages;
  for (const SentFrame& frame : framesOf(bytes))
    if (frame.header.type == static_cast<uint8_t>(type))
      messages.push_back(proto::decode<Message>(frame.body));
  return messages;
}

inline std::vector<proto::RequestChange> changesOf(const Bytes& bytes) {
  std::vector<proto::RequestChange> changes;
  for (const auto& requests : messagesOf<proto::Requests>(bytes, FrameType::kRequests))
    changes.insert(changes.end(), requests.changes.begin(), requests.changes.end());
  return changes;
}

inline Bytes blobBytes(uint32_t number, size_t size) {
  Bytes bytes(size);
  for (size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(number * 31 + i * 7);
  return bytes;
}

inline BlobRef blobRef(uint32_t number, size_t size) {
  return {number, static_cast<uint32_t>(size), digestOf(blobBytes(number, size))};
}

inline Bytes frameOf(FrameType type, uint8_t flags, std::span<const std::byte> body) {
  const auto header =
      proto::encodeFrameHeader({static_cast<uint32_t>(body.size()), static_cast<uint8_t>(type), flags, 0});
  Bytes frame(header.size() + body.size());
  std::copy(body.begin(), body.end(), std::copy(header.begin(), header.end(), frame.begin()));
  return frame;
}

inline Bytes chunkFrame(uint32_t request, uint32_t total, uint32_t offset, std::span<const std::byte> bytes) {
  const auto fields = proto::encodeBlobChunkHeader({request, total, offset});
  Bytes body(fields.size() + bytes.size());
  std::copy(bytes.begin(), bytes.end(), std::copy(fields.begin(), fields.end(), body.begin()));
  return frameOf(FrameType::kBlob, 0, body);
}

/// Returns a whole blob as frames of at most 32 KB.
inline Bytes blobFrames(uint32_t request, uint32_t number, size_t size) {
  const Bytes blob = blobBytes(number, size);
  Bytes frames;
  for (size_t offset = 0; offset < size; offset += proto::kMaxChunkBytes) {
    const auto chunk =
        std::span(blob).subspan(offset, std::min<size_t>(proto::kMaxChunkBytes, size - offset));
    const Bytes frame =
        chunkFrame(request, static_cast<uint32_t>(size), static_cast<uint32_t>(offset), chunk);
    frames.insert(frames.end(), frame.begin(), frame.end());
  }
  return frames;
}

constexpr uint32_t kPageBlob = 1, kPageBytes = 300;

inline Bytes welcome() { return proto::encode(proto::Welcome{proto::kProtocolVersion, 0, 16384, "test"}, 1); }

inline Bytes opened() {
  proto::Opened message;
  message.handle = 7;
  message.summary.name = "model";
  message.summary.nodes = 9;
  message.summary.root_page = blobRef(kPageBlob, kPageBytes);
  return proto::encode(message, 2);
}

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

inline SessionOptions optionsFor(const std::string& model) {
  SessionOptions options;
  options.model = model;
  return options;
}

/// A session that opens model "model", with a scripted server.
class SessionTest : public testing::Test {
 protected:
  std::vector<SessionEvent> give(const Bytes& bytes, TimePoint now = kStart) {
    session_.receive(bytes, now);
    std::vector<SessionEvent> events;
    while (auto event = session_.nextEvent()) events.push_back(std::move(*event));
    return events;
  }
  /// Opens the model and receives its root page.
  void open() {
    give(welcome() + opened() + blobFrames(0, kPageBlob, kPageBytes));
    session_.takeOutgoing();
  }
  /// Requests one blob. @return the request number.
  uint32_t makeRequest(const BlobRef& blob) {
    session_.setRequests(std::vector<Request>{{blob, {}, proto::RequestClass::kVisible, 10}});
    const auto changes = changesOf(session_.takeOutgoing());
    return changes.empty() ? 0 : changes.back().request;
  }
  /// Calls tick() every second. @return the time of the last call.
  TimePoint listen(TimePoint from, int seconds) {
    for (; seconds > 0; --seconds) session_.tick(from += std::chrono::seconds(1));
    return from;
  }
  void expectRefused(const Bytes& bytes, const std::string& part_of_message, Remedy remedy = Remedy::kNone) {
    try {
      give(bytes);
      FAIL() << "not refused";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(part_of_message), std::string::npos) << error.what();
      EXPECT_EQ(error.remedy(), remedy);
    }
  }

  Session session_{optionsFor("model"), kStart};
};

}  // namespace lode::core::fixture
