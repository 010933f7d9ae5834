#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <flatbuffers/flatbuffers.h>

#include "common/codec/texture_set.h"
#include "common/limits.h"
#include "common/node_key.h"
#include "proto/check.h"
#include "proto/limits.h"
#include "proto/lodestream_generated.h"
#include "proto/messages.h"

namespace lode::proto {

namespace {

std::string getString(const flatbuffers::String* text, uint32_t limit, const char* what) {
  if (text == nullptr) return {};
  requireAtMost(text->size(), limit, what);
  const std::string_view view(text->c_str(), text->size());
  require(isWireText(view), "a string is not printable UTF-8");
  return std::string(view);
}

Digest fromWire(const wire::Digest& name) {
  Digest out;
  std::memcpy(out.bytes.data(), name.bytes()->Data(), out.bytes.size());
  return out;
}

BlobRef fromWire(const wire::BlobRef& blob) {
  return {blob.number(), blob.bytes(), fromWire(*blob.digest())};
}

glm::uvec3 fromWire(const wire::LatticePoint& p) { return {p.x(), p.y(), p.z()}; }

ModelSummary fromWire(const wire::ModelSummary& from) {
  ModelSummary out;
  out.name = getString(from.name(), kMaxModelNameBytes, "bytes in a model's name");
  require(!out.name.empty(), "a model without a name");
  out.build_id = fromWire(*from.build_id());
  out.lattice.origin = {from.origin()->x(), from.origin()->y(), from.origin()->z()};
  out.lattice.step = from.step();
  require(std::isfinite(out.lattice.origin.x) && std::isfinite(out.lattice.origin.y) &&
              std::isfinite(out.lattice.origin.z) && isLatticeStep(out.lattice.step),
          "a lattice that is no lattice");
  out.box = {fromWire(from.box()->min()), fromWire(from.box()->max())};
  const glm::uvec3 all = glm::max(out.box.min, out.box.max);
  require(std::max({all.x, all.y, all.z}) <= kMaxLattice, "a box outside the lattice");
  out.attributes.bits = from.attributes();
  require((out.attributes.bits & ~(AttributeSet::kAll | AttributeSet::kComputedNormal)) == 0,
          "an unknown attribute");
  out.triangles = from.triangles();
  out.dropped = from.dropped();
  out.stored_triangles = from.stored_triangles();
  out.nodes = from.nodes();
  requireAtMost(out.nodes, kMaxNodes, "nodes in a model");
  out.payloads = from.payloads();
  out.bytes = from.bytes();
  out.depth = from.depth();
  requireAtMost(out.depth, kMaxDepth, "levels in a model");
  out.max_error_model = from.max_error_model();
  require(std::isfinite(out.max_error_model) && out.max_error_model >= 0, "an error that is no length");
  out.triangles_per_node = from.triangles_per_node();
  out.root_page = fromWire(*from.root_page());
  require(out.root_page.number != 0, "a model without a root page");
  requireAtMost(out.root_page.bytes, kMaxPageBytes, "bytes in a root page");
  if (from.textures() != nullptr) {
    out.textures = fromWire(*from.textures());
    require(out.textures.number != 0 && out.textures.bytes != 0, "a texture set that is no blob");
    requireAtMost(out.textures.bytes, kMaxTextureSetBytes, "bytes in a texture set");
  }
  return out;
}

/// The generated type of a message's table.
template <typename Message>
struct WireOf;
template <>
struct WireOf<Hello> {
  using Type = wire::Hello;
};
template <>
struct WireOf<Welcome> {
  using Type = wire::Welcome;
};
template <>
struct WireOf<List> {
  using Type = wire::List;
};
template <>
struct WireOf<Models> {
  using Type = wire::Models;
};
template <>
struct WireOf<Open> {
  using Type = wire::Open;
};
template <>
struct WireOf<Opened> {
  using Type = wire::Opened;
};
template <>
struct WireOf<Requests> {
  using Type = wire::Requests;
};
template <>
struct WireOf<Credit> {
  using Type = wire::Credit;
};
template <>
struct WireOf<Cancelled> {
  using Type = wire::Cancelled;
};
template <>
struct WireOf<ErrorMessage> {
  using Type = wire::Error;
};
template <>
struct WireOf<GoAway> {
  using Type = wire::GoAway;
};
template <>
struct WireOf<ModelReplaced> {
  using Type = wire::ModelReplaced;
};
template <>
struct WireOf<Ping> {
  using Type = wire::Ping;
};
template <>
struct WireOf<Pong> {
  using Type = wire::Pong;
};
template <>
struct WireOf<Close> {
  using Type = wire::Close;
};
template <>
struct WireOf<Closed> {
  using Type = wire::Closed;
};

/// Calls `read` with the body's root table, once the body is known to hold one.
template <typename Root, typename Read>
auto withRoot(std::span<const std::byte> body, Read read) {
  requireAtMost(body.size(), kMaxFrameBodyBytes, "bytes in a frame's body");
  std::vector<std::max_align_t> aligned;
  const std::byte* start = body.data();
  if (reinterpret_cast<uintptr_t>(start) % alignof(uint64_t) != 0) {
    aligned.resize(body.size() / sizeof(std::max_align_t) + 1);
    std::memcpy(aligned.data(), body.data(), body.size());
    start = reinterpret_cast<const std::byte*>(aligned.data());
  }
  const auto* bytes = reinterpret_cast<const uint8_t*>(start);
  flatbuffers::Verifier verifier(bytes, body.size(), 8, 3 * kMaxListedModels + kMaxRequestsPerFrame);
  require(!body.empty() && verifier.VerifyBuffer<Root>(nullptr), "its body is no FlatBuffer of its type");
  return read(*flatbuffers::GetRoot<Root>(bytes));
}

Hello fromWire(const wire::Hello& from) {
  Hello out;
  out.min_version = from.min_version();
  out.max_version = from.max_version();
  require(out.min_version >= 1 && out.min_version <= out.max_version, "a range of versions that is none");
  out.features = from.features();
  out.token = getString(from.token(), kMaxTokenBytes, "bytes in a token");
  out.program = getString(from.program(), kMaxStringBytes, "bytes in a program's name");
  return out;
}

Welcome fromWire(const wire::Welcome& from) {
  require(from.version() >= 1, "a version that is none");
  return {from.version(), from.features(), from.max_open_requests(),
          getString(from.program(), kMaxStringBytes, "bytes in a program's name")};
}

List fromWire(const wire::List&) { return {}; }

Models fromWire(const wire::Models& from) {
  Models out;
  if (from.models() == nullptr) return out;
  requireAtMost(from.models()->size(), kMaxListedModels, "models in a list");
  out.models.reserve(from.models()->size());
  for (const wire::ModelSummary* summary : *from.models()) out.models.push_back(fromWire(*summary));
  return out;
}

Open fromWire(const wire::Open& from) {
  Open out;
  out.model = getString(from.model(), kMaxModelNameBytes, "bytes in a model's name");
  if (from.known_build_id() != nullptr) out.known_build_id = fromWire(*from.known_build_id());
  return out;
}

Opened fromWire(const wire::Opened& from) {
  require(from.handle() != 0, "a model's handle is zero");
  return {from.handle(), fromWire(*from.summary())};
}

RequestChange fromWire(const wire::RequestChange& from) {
  require(from.action() <= static_cast<uint8_t>(RequestAction::kCancel), "an unknown action on a request");
  require(from.request_class() <= static_cast<uint8_t>(RequestClass::kPrefetch),
          "an unknown class of request");
  require(from.request() != 0, "request 0 is the server's own");
  require(!std::isnan(from.priority_px()), "a priority that is not a number");
  return {static_cast<RequestAction>(from.action()), static_cast<RequestClass>(from.request_class()),
          from.request(), from.blob(), from.priority_px()};
}

void read(const wire::Requests& from, Requests& into) {
  into.handle = from.handle();
  into.changes.clear();
  if (from.changes() == nullptr) return;
  requireAtMost(from.changes()->size(), kMaxRequestsPerFrame, "requests in a frame");
  into.changes.reserve(from.changes()->size());
  for (const wire::RequestChange* change : *from.changes()) into.changes.push_back(fromWire(*change));
}

Requests fromWire(const wire::Requests& from) {
  Requests out;
  read(from, out);
  return out;
}

Credit fromWire(const wire::Credit& from) { return {from.granted_bytes()}; }
Cancelled fromWire(const wire::Cancelled& from) { return {from.request()}; }

/// A code that a later version may add is taken as kInternal.
WireError toWireError(uint8_t code) {
  const bool known = code >= static_cast<uint8_t>(WireError::kMalformed) &&
                     code <= static_cast<uint8_t>(WireError::kInternal);
  return known ? static_cast<WireError>(code) : WireError::kInternal;
}

ErrorMessage fromWire(const wire::Error& from) {
  return {toWireError(from.code()), from.request(), from.closes(),
          getString(from.message(), kMaxStringBytes, "bytes in an error's text")};
}

GoAway fromWire(const wire::GoAway& from) {
  return {getString(from.reason(), kMaxStringBytes, "bytes in a reason")};
}

ModelReplaced fromWire(const wire::ModelReplaced& from) { return {from.handle()}; }
Ping fromWire(const wire::Ping& from) { return {from.payload()}; }
Pong fromWire(const wire::Pong& from) { return {from.payload()}; }
Close fromWire(const wire::Close& from) { return {from.handle()}; }
Closed fromWire(const wire::Closed& from) { return {from.handle()}; }

}  // namespace

template <typename Message>
Message decode(std::span<const std::byte> body) {
  return withRoot<typename WireOf<Message>::Type>(body, [](const auto& root) { return fromWire(root); });
}

void decodeInto(std::span<const std::byte> body, Requests& into) {
  withRoot<wire::Requests>(body, [&into](const wire::Requests& root) { read(root, into); });
}

template Hello decode<Hello>(std::span<const std::byte>);
template Welcome decode<Welcome>(std::span<const std::byte>);
template List decode<List>(std::span<const std::byte>);
template Models decode<Models>(std::span<const std::byte>);
template Open decode<Open>(std::span<const std::byte>);
template Opened decode<Opened>(std::span<const std::byte>);
template Requests decode<Requests>(std::span<const std::byte>);
template Credit decode<Credit>(std::span<const std::byte>);
template Cancelled decode<Cancelled>(std::span<const std::byte>);
template ErrorMessage decode<ErrorMessage>(std::span<const std::byte>);
template GoAway decode<GoAway>(std::span<const std::byte>);
template ModelReplaced decode<ModelReplaced>(std::span<const std::byte>);
template Ping decode<Ping>(std::span<const std::byte>);
template Pong decode<Pong>(std::span<const std::byte>);
template Close decode<Close>(std::span<const std::byte>);
template Closed decode<Closed>(std::span<const std::byte>);

}  // namespace lode::proto
