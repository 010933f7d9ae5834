#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "proto/frame.h"
#include "server/serve/session/session.h"

namespace lode::serve::test {

using namespace std::chrono_literals;
using proto::FrameType;
using proto::RequestAction;
using proto::RequestClass;
using proto::WireError;

constexpr uint32_t kSmall = 1000, kLarge = 200'000, kPageBlob = 1, kRootLodBlob = 2, kFirstBlob = 3;

/// Makes a model whose blobs 3 to 29 are small and 30 to 39 large.
inline Model model(const std::string& name, uint8_t build = 1) {
  Model model;
  model.summary.name = name;
  model.summary.build_id.bytes[0] = std::byte{build};
  model.summary.lattice.step = 0.5;
  model.summary.root_page = {kPageBlob, 300, {}};
  model.blob_bytes.assign(40, kSmall);
  model.blob_bytes[0] = 0;
  model.blob_bytes[kPageBlob] = 300;
  std::fill(model.blob_bytes.begin() + 30, model.blob_bytes.end(), kLarge);
  model.coarsest_blob = kRootLodBlob;
  return model;
}

inline std::shared_ptr<const Catalog> catalogOf(std::vector<Model> models) {
  std::vector<std::shared_ptr<const Model>> shared;
  for (Model& each : models) shared.push_back(std::make_shared<const Model>(std::move(each)));
  return std::make_shared<const Catalog>(std::move(shared));
}

/// A session with a scripted client; every blob is readable.
class SessionTest : public testing::Test {
 protected:
  template <typename Message>
  void send(const Message& message, uint32_t call = 0) {
    sendTo(session_, message, call);
  }
  template <typename Message>
  void sendTo(Session& session, const Message& message, uint32_t call = 0) {
    const proto::Bytes frame = proto::encode(message, call);
    session.receive(headerOf(frame), std::span(frame).subspan(proto::kFrameHeaderBytes), now_);
  }
  void sendRaw(uint8_t type, uint8_t flags, const proto::Bytes& body = {}) {
    session_.receive({static_cast<uint32_t>(body.size()), type, flags, 0}, body, now_);
  }

  /// Sends Hello, opens model "a" as handle 1 and takes the two blobs that follow Opened.
  void open() {
    send(proto::Hello{});
    send(proto::Open{"a", {}});
    session_.takeControl();
    while (session_.beginChunk()) session_.finishChunk();
  }

  void request(RequestClass request_class, uint32_t id, uint32_t blob, float priority_px, uint32_t call = 0) {
    send(proto::Requests{1, {{RequestAction::kAdd, request_class, id, blob, priority_px}}}, call);
  }
  void change(RequestAction action, RequestClass request_class, uint32_t id, float priority_px = 0) {
    send(proto::Requests{1, {{action, request_class, id, 0, priority_px}}});
  }

  /// Sends the next chunk. @return the request id in its header, or nothing.
  std::optional<uint32_t> sendChunk() {
    const auto chunk = session_.beginChunk();
    if (!chunk || !session_.finishChunk()) return {};
    sent_bytes_ += proto::kBlobChunkHeaderBytes + chunk->bytes;
    return chunk->header.request;
  }

  struct Received {
    proto::FrameHeader header;
    proto::Bytes body;
  };
  std::vector<Received> control() {
    const proto::Bytes bytes = session_.takeControl();
    std::vector<Received> frames;
    for (size_t at = 0; at < bytes.size();) {
      const auto header = proto::decodeFrameHeader(
          std::span<const std::byte, proto::kFrameHeaderBytes>(bytes.data() + at, proto::kFrameHeaderBytes));
      at += proto::kFrameHeaderBytes;
      const auto start = bytes.begin() + static_cast<std::ptrdiff_t>(at);
      frames.push_back({header, proto::Bytes(start, start + header.body_bytes)});
      at += header.body_bytes;
    }
    return frames;
  }
  template <typename Message>
  Message only(FrameType type, uint32_t call = 0) {
    const auto frames = control();
    EXPECT_EQ(frames.size(), 1u);
    if (frames.empty()) return {};
    EXPECT_EQ(frames[0].header.type, static_cast<uint8_t>(type));
    EXPECT_EQ(frames[0].header.call, call);
    return proto::decode<Message>(frames[0].body);
  }
  void expectClosedWith(WireError code) {
    const auto error = only<proto::ErrorMessage>(FrameType::kError);
    EXPECT_EQ(error.code, code) << error.message;
    EXPECT_TRUE(error.closes);
    EXPECT_TRUE(session_.closing());
    EXPECT_TRUE(session_.finished());
  }

  static proto::FrameHeader headerOf(const proto::Bytes& frame) {
    return proto::decodeFrameHeader(
        std::span<const std::byte, proto::kFrameHeaderBytes>(frame.data(), proto::kFrameHeaderBytes));
  }

  const Model& modelAt(size_t index) const { return *served_.catalog->models()[index]; }

  ServedSet served_{catalogOf({model("a"), model("b")}), nullptr};
  MemoryBudget budget_{256u << 20};
  MemoryAccount memory_{budget_};
  SessionHost host_{&served_, &memory_};
  Clock::time_point now_{1000s};
  SessionLimits limits_{100, 10s, 120s, 5};
  Session session_{host_, limits_, now_};
  uint64_t sent_bytes_ = 0;
};

}  // namespace lode::serve::test
