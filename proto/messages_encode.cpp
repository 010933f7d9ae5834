#include <array>
#include <cstring>

#include <flatbuffers/flatbuffers.h>

#include "common/limits.h"
#include "common/printable.h"
#include "proto/check.h"
#include "proto/limits.h"
#include "proto/lodestream_generated.h"
#include "proto/messages.h"

namespace lode::proto {

namespace {

using Builder = flatbuffers::FlatBufferBuilder;

/// Text for people, made fit to send: cut to the limit, anything else than printable UTF-8 replaced.
std::string presentable(std::string_view text) {
  std::string out(text.substr(0, kMaxStringBytes));
  while (!out.empty() && out.size() < text.size() && (static_cast<uint8_t>(out.back()) & 0xC0) == 0x80)
    out.pop_back();  // the cut fell into a character: its lead byte goes too, below
  if (out.size() < text.size() && !out.empty() && static_cast<uint8_t>(out.back()) >= 0xC0) out.pop_back();
  const bool ascii_only = !isWireText(out);
  for (char& c : out)
    if (static_cast<uint8_t>(c) < 0x20 || c == 0x7F || (ascii_only && static_cast<uint8_t>(c) >= 0x80))
      c = '?';
  return out;
}

std::string_view checked(std::string_view text, uint32_t limit, const char* what) {
  requireAtMost(text.size(), limit, what);
  require(isWireText(text), "a string is not printable UTF-8");
  return text;
}

auto put(Builder& builder, std::string_view text) { return builder.CreateString(text.data(), text.size()); }

wire::Digest toWire(const Digest& name) {
  std::array<uint8_t, 16> bytes;
  std::memcpy(bytes.data(), name.bytes.data(), bytes.size());
  return wire::Digest(bytes);
}

wire::LatticePoint toWire(glm::uvec3 p) { return {p.x, p.y, p.z}; }

flatbuffers::Offset<wire::BlobRef> put(Builder& builder, const BlobRef& blob) {
  const wire::Digest name = toWire(blob.digest);
  return wire::CreateBlobRef(builder, blob.number, blob.bytes, &name);
}

flatbuffers::Offset<wire::ModelSummary> put(Builder& builder, const ModelSummary& summary) {
  const auto name = put(builder, checked(summary.name, kMaxModelNameBytes, "bytes in a model's name"));
  const wire::Digest build_id = toWire(summary.build_id);
  const wire::DVec3 origin(summary.lattice.origin.x, summary.lattice.origin.y, summary.lattice.origin.z);
  const wire::LatticeBox box(toWire(summary.box.min), toWire(summary.box.max));
  const auto page = put(builder, summary.root_page);
  flatbuffers::Offset<wire::BlobRef> textures;
  if (summary.textures) textures = put(builder, summary.textures);
  return wire::CreateModelSummary(
      builder, name, &build_id, &origin, summary.lattice.step, &box, summary.attributes.bits,
      summary.triangles, summary.dropped, summary.stored_triangles, summary.nodes, summary.payloads,
      summary.bytes, summary.depth, summary.max_error_model, summary.triangles_per_node, page, textures);
}

template <typename Root>
Bytes finish(Builder& builder, flatbuffers::Offset<Root> root, FrameType type, uint32_t call) {
  builder.Finish(root);
  requireAtMost(builder.GetSize(), kMaxFrameBodyBytes, "bytes in a frame's body");
  const auto header = encodeFrameHeader({builder.GetSize(), static_cast<uint8_t>(type), 0, call});
  Bytes frame(kFrameHeaderBytes + builder.GetSize());
  std::memcpy(frame.data(), header.data(), header.size());
  std::memcpy(frame.data() + header.size(), builder.GetBufferPointer(), builder.GetSize());
  return frame;
}

}  // namespace

bool isWireText(std::string_view text) noexcept { return isPrintableUtf8(text); }

Bytes encode(const Hello& message, uint32_t call) {
  Builder builder;
  const auto token = put(builder, checked(message.token, kMaxTokenBytes, "bytes in a token"));
  const auto program = put(builder, presentable(message.program));
  return finish(
      builder,
      wire::CreateHello(builder, message.min_version, message.max_version, message.features, token, program),
      FrameType::kHello, call);
}

Bytes encode(const Welcome& message, uint32_t call) {
  Builder builder;
  const auto program = put(builder, presentable(message.program));
  return finish(
      builder,
      wire::CreateWelcome(builder, message.version, message.features, message.max_open_requests, program),
      FrameType::kWelcome, call);
}

Bytes encode(const List&, uint32_t call) {
  Builder builder;
  return finish(builder, wire::CreateList(builder), FrameType::kList, call);
}

Bytes encode(const Models& message, uint32_t call) {
  requireAtMost(message.models.size(), kMaxListedModels, "models in a list");
  Builder builder;
  std::vector<flatbuffers::Offset<wire::ModelSummary>> models;
  models.reserve(message.models.size());
  for (const ModelSummary& summary : message.models) models.push_back(put(builder, summary));
  return finish(builder, wire::CreateModels(builder, builder.CreateVector(models)), FrameType::kModels, call);
}

Bytes encode(const Open& message, uint32_t call) {
  Builder builder;
  const auto model = put(builder, checked(message.model, kMaxModelNameBytes, "bytes in a model's name"));
  const wire::Digest known = toWire(message.known_build_id);
  const bool knows = message.known_build_id != Digest{};
  return finish(builder, wire::CreateOpen(builder, model, knows ? &known : nullptr), FrameType::kOpen, call);
}

Bytes encode(const Opened& message, uint32_t call) {
  Builder builder;
  const auto summary = put(builder, message.summary);
  return finish(builder, wire::CreateOpened(builder, message.handle, summary), FrameType::kOpened, call);
}

Bytes encode(const Requests& message, uint32_t call) {
  requireAtMost(message.changes.size(), kMaxRequestsPerFrame, "requests in a frame");
  Builder builder(64 + 32 * message.changes.size());
  std::vector<flatbuffers::Offset<wire::RequestChange>> changes;
  changes.reserve(message.changes.size());
  for (const RequestChange& change : message.changes)
    changes.push_back(wire::CreateRequestChange(builder, static_cast<uint8_t>(change.action),
                                                static_cast<uint8_t>(change.request_class), change.request,
                                                change.blob, change.priority_px));
  return finish(builder, wire::CreateRequests(builder, message.handle, builder.CreateVector(changes)),
                FrameType::kRequests, call);
}

Bytes encode(const Credit& message, uint32_t call) {
  Builder builder(64);
  return finish(builder, wire::CreateCredit(builder, message.granted_bytes), FrameType::kCredit, call);
}

Bytes encode(const Cancelled& message, uint32_t call) {
  Builder builder(64);
  return finish(builder, wire::CreateCancelled(builder, message.request), FrameType::kCancelled, call);
}

Bytes encode(const ErrorMessage& message, uint32_t call) {
  Builder builder(256);
  const auto text = put(builder, presentable(message.message));
  return finish(
      builder,
      wire::CreateError(builder, static_cast<uint8_t>(message.code), message.request, message.closes, text),
      FrameType::kError, call);
}

Bytes encode(const GoAway& message, uint32_t call) {
  Builder builder(256);
  const auto reason = put(builder, presentable(message.reason));
  return finish(builder, wire::CreateGoAway(builder, reason), FrameType::kGoAway, call);
}

Bytes encode(const ModelReplaced& message, uint32_t call) {
  Builder builder(64);
  return finish(builder, wire::CreateModelReplaced(builder, message.handle), FrameType::kModelReplaced, call);
}

Bytes encode(const Ping& message, uint32_t call) {
  Builder builder(64);
  return finish(builder, wire::CreatePing(builder, message.payload), FrameType::kPing, call);
}

Bytes encode(const Pong& message, uint32_t call) {
  Builder builder(64);
  return finish(builder, wire::CreatePong(builder, message.payload), FrameType::kPong, call);
}

Bytes encode(const Close& message, uint32_t call) {
  Builder builder(64);
  return finish(builder, wire::CreateClose(builder, message.handle), FrameType::kClose, call);
}

Bytes encode(const Closed& message, uint32_t call) {
  Builder builder(64);
  return finish(builder, wire::CreateClosed(builder, message.handle), FrameType::kClosed, call);
}

}  // namespace lode::proto
