#pragma once

#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "client/core/engine.h"
#include "proto/limits.h"
#include "tests/unit/core/session_fixture.h"

namespace lode::core {

using proto::Bytes;

using fixture::kStart;

/// Returns triangles in the plane z = 0; their number identifies the LOD.
inline Mesh stripOf(uint32_t triangles) {
  Mesh mesh;
  for (uint32_t i = 0; i < triangles + 2; ++i) mesh.positions.push_back(packPosition({i / 2, i % 2, 0}));
  for (uint32_t i = 0; i < triangles; ++i)
    mesh.triangles.push_back(i % 2 == 0 ? glm::u32vec3(i, i + 1, i + 2) : glm::u32vec3(i + 1, i, i + 2));
  return mesh;
}

/// A model of one node with two LODs, and its server as bytes in process.
class EngineTest : public testing::Test {
 protected:
  void SetUp() override {
    const EncodedPayload fine = encodePayload(stripOf(40), 1), coarse = encodePayload(stripOf(4), 1);
    blobs_ = {fine.bytes, coarse.bytes};
    root_.key = kRootKey;
    root_.box.add(glm::uvec3(0));
    root_.box.add(glm::uvec3(21, 1, 0));
    root_.lods = {{refOf(1), 40, fine.vertices, 0, 0.001f, 0}, {refOf(2), 4, coarse.vertices, 0, 10, 0}};
    blobs_.push_back(encodePage({{root_}}));
    view_.eye_model = {10, 0, 40};
  }

  BlobRef refOf(uint32_t number) const {
    const Bytes& blob = blobs_[number - 1];
    return {number, static_cast<uint32_t>(blob.size()), digestOf(blob)};
  }

  static void append(Bytes& to, const Bytes& more) { to.insert(to.end(), more.begin(), more.end()); }

  Bytes blobFrame(uint32_t request, uint32_t number) const {
    const Bytes& blob = blobs_[number - 1];
    const auto fields = proto::encodeBlobChunkHeader({request, static_cast<uint32_t>(blob.size()), 0});
    const auto header = proto::encodeFrameHeader({static_cast<uint32_t>(fields.size() + blob.size()),
                                                  static_cast<uint8_t>(proto::FrameType::kBlob), 0, 0});
    Bytes frame(header.size() + fields.size() + blob.size());
    auto at = std::copy(header.begin(), header.end(), frame.begin());
    at = std::copy(fields.begin(), fields.end(), at);
    std::copy(blob.begin(), blob.end(), at);
    return frame;
  }

  /// Opens the model and receives the root page.
  Bytes openingOf(const Digest& known) const {
    proto::Opened opened;
    opened.handle = 1;
    opened.summary.name = "strip";
    opened.summary.nodes = nodes_;
    opened.summary.build_id = build_id_;
    opened.summary.lattice.step = step_;
    opened.summary.root_page = refOf(3);
    Bytes bytes = proto::encode(proto::Welcome{proto::kProtocolVersion, 0, 100, ""}, 1);
    append(bytes, proto::encode(opened, 2));
    if (known != build_id_) append(bytes, blobFrame(0, 3));
    return bytes;
  }

  /// @param known  the build that the client has: the server sends no blobs of it without a request.
  Bytes greeting(const Digest& known = {}) const {
    Bytes bytes = openingOf(known);
    if (known != build_id_) append(bytes, blobFrame(0, 2));
    return bytes;
  }

  void decodeAll() {
    for (const DecodeJob& job : engine_.takeDecodeJobs()) engine_.finishDecode(runDecodeJob(job));
  }

  /// Returns the request for the fine LOD once the coarse one is shown.
  uint32_t openAndShowCoarse() {
    engine_.setView(view_, 1);
    engine_.connect(kStart);
    engine_.receive(greeting(), kStart);
    engine_.takeOutgoing();
    decodeAll();
    engine_.step(kStart);
    return firstRequest();
  }

  /// Returns the request in the bytes that the engine sends now; 0: none.
  uint32_t firstRequest() { return firstRequestOf(engine_); }
  uint32_t firstRequestOf(Engine& engine) {
    uint32_t request = 0;
    std::span<const std::byte> rest = sent_ = engine.takeOutgoing();
    while (!rest.empty()) {
      const auto header = proto::decodeFrameHeader(rest.first<proto::kFrameHeaderBytes>());
      if (header.type == static_cast<uint8_t>(proto::FrameType::kRequests))
        request = proto::decode<proto::Requests>(rest.subspan(proto::kFrameHeaderBytes, header.body_bytes))
                      .changes.at(0)
                      .request;
      rest = rest.subspan(proto::kFrameHeaderBytes + header.body_bytes);
    }
    return request;
  }

  /// Refuses a request, or with 0 an unasked blob, because the store cannot be read now.
  static Bytes unreadable(uint32_t request) {
    return proto::encode(proto::ErrorMessage{proto::WireError::kInternal, request, false, "cannot be read"},
                         2);
  }

  /// Opens a model whose coarsest LOD the server refuses, because the store is damaged.
  void openWithoutTheCoarsest() {
    engine_.setView(view_, 1000);
    engine_.connect(kStart);
    Bytes bytes = openingOf({});
    append(bytes,
           proto::encode(proto::ErrorMessage{proto::WireError::kDamagedStore, 0, false, "damaged"}, 2));
    engine_.receive(bytes, kStart);
    engine_.step(kStart);
  }

  static constexpr TimePoint kMoved = kStart + kMoveOn;

  /// The server shuts down with an open request while the next one is connected. @return the request.
  uint32_t moveOn() {
    const uint32_t request = openAndShowCoarse();
    engine_.receive(proto::encode(proto::GoAway{"drain"}, 0), kStart);
    EXPECT_TRUE(engine_.wantsConnection(kMoved));
    engine_.connect(kMoved);
    engine_.takeOutgoing();
    engine_.receive(greeting(build_id_), kMoved);
    engine_.takeOutgoing();
    engine_.step(kMoved);
    return request;
  }

  static EngineOptions options() {
    EngineOptions options;
    options.session.model = "strip";
    return options;
  }

  std::vector<Bytes> blobs_;
  Node root_;
  Digest build_id_{{std::byte{1}}};
  uint32_t nodes_ = 1;
  double step_ = Lattice{}.step;
  View view_;
  Bytes sent_;
  Engine engine_{options()};
};

}  // namespace lode::core
