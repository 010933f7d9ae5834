#include "proto/messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <type_traits>

#include <flatbuffers/flatbuffers.h>

#include "common/codec/texture_set.h"
#include "common/error.h"
#include "common/limits.h"
#include "common/node_key.h"
#include "common/printable.h"
#include "proto/lodestream_generated.h"

namespace lode::proto {

namespace {

using Builder = flatbuffers::FlatBufferBuilder;

/// Initial size of a Builder, which suffices for messages without strings and lists.
constexpr size_t kBuilderBytes = 64;

template <typename Table>
using Offset = flatbuffers::Offset<Table>;

/// Checks a condition. @throws Error kProtocol with `what` unless `good`.
void require(bool good, const char* what) {
  if (!good) throw Error(ErrorCode::kProtocol, std::string("a malformed message: ") + what);
}

/// Checks a limit. @throws Error kLimit with the value and the limit if value > limit.
void requireAtMost(uint64_t value, uint64_t limit, const char* what) {
  if (value > limit)
    throw Error(ErrorCode::kLimit, "a message has " + std::to_string(value) + " " + what + "; the limit is " +
                                       std::to_string(limit));
}

std::string_view checkText(std::string_view text, uint32_t limit, const char* what) {
  requireAtMost(text.size(), limit, what);
  require(isPrintableUtf8(text), "a string is not printable UTF-8");
  return text;
}

/// Returns a text as a message may contain it. Cuts the text to kMaxStringBytes. If it is not printable
/// UTF-8, replaces every byte that is not printable ASCII with '?'. Use it for texts that only people read,
/// such as reasons and names of programs.
std::string sanitized(std::string_view text) {
  std::string out(text.substr(0, kMaxStringBytes));
  // If the cut is inside a character, remove the whole character: the continuation bytes here, the lead byte
  // below.
  while (!out.empty() && out.size() < text.size() && (static_cast<uint8_t>(out.back()) & 0xC0) == 0x80)
    out.pop_back();
  if (out.size() < text.size() && !out.empty() && static_cast<uint8_t>(out.back()) >= 0xC0) out.pop_back();
  const bool ascii_only = !isPrintableUtf8(out);
  for (char& c : out)
    if (static_cast<uint8_t>(c) < 0x20 || c == 0x7F || (ascii_only && static_cast<uint8_t>(c) >= 0x80))
      c = '?';
  return out;
}

auto write(Builder& builder, std::string_view text) { return builder.CreateString(text.data(), text.size()); }

std::string read(const flatbuffers::String* text, uint32_t limit, const char* what) {
  if (text == nullptr) return {};
  return std::string(checkText({text->c_str(), text->size()}, limit, what));
}

// Parts of messages: write() converts a part to its FlatBuffers type, read() checks a part and converts it
// back.

wire::Digest write(const Digest& digest) {
  std::array<uint8_t, 16> bytes;
  std::memcpy(bytes.data(), digest.bytes.data(), bytes.size());
  return wire::Digest(bytes);
}

Digest read(const wire::Digest& from) {
  Digest out;
  std::memcpy(out.bytes.data(), from.bytes()->Data(), out.bytes.size());
  return out;
}

Offset<wire::BlobRef> write(Builder& builder, const BlobRef& blob) {
  const wire::Digest digest = write(blob.digest);
  return wire::CreateBlobRef(builder, blob.number, blob.bytes, &digest);
}

BlobRef read(const wire::BlobRef& from) { return {from.number(), from.bytes(), read(*from.digest())}; }

wire::LatticePoint write(glm::uvec3 p) { return {p.x, p.y, p.z}; }

glm::uvec3 read(const wire::LatticePoint& p) { return {p.x(), p.y(), p.z()}; }

Offset<wire::ModelSummary> write(Builder& builder, const ModelSummary& summary) {
  const auto name = write(builder, checkText(summary.name, kMaxModelNameBytes, "bytes in a model's name"));
  const wire::Digest build_id = write(summary.build_id);
  const wire::DVec3 origin(summary.lattice.origin.x, summary.lattice.origin.y, summary.lattice.origin.z);
  const wire::LatticeBox box(write(summary.box.min), write(summary.box.max));
  const auto root_page = write(builder, summary.root_page);
  Offset<wire::BlobRef> textures;
  if (summary.textures) textures = write(builder, summary.textures);
  return wire::CreateModelSummary(
      builder, name, &build_id, &origin, summary.lattice.step, &box, summary.attributes.bits,
      summary.triangles, summary.dropped, summary.stored_triangles, summary.nodes, summary.payloads,
      summary.bytes, summary.depth, summary.max_error_model, summary.triangles_per_node, root_page, textures);
}

ModelSummary read(const wire::ModelSummary& from) {
  ModelSummary out;
  out.name = read(from.name(), kMaxModelNameBytes, "bytes in a model's name");
  require(!out.name.empty(), "a model has no name");
  out.build_id = read(*from.build_id());
  out.lattice.origin = {from.origin()->x(), from.origin()->y(), from.origin()->z()};
  out.lattice.step = from.step();
  require(std::isfinite(out.lattice.origin.x) && std::isfinite(out.lattice.origin.y) &&
              std::isfinite(out.lattice.origin.z) && isLatticeStep(out.lattice.step),
          "a lattice has an invalid origin or step");
  out.box = {read(from.box()->min()), read(from.box()->max())};
  const glm::uvec3 all = glm::max(out.box.min, out.box.max);
  require(std::max({all.x, all.y, all.z}) <= kMaxLattice, "a box is outside the lattice");
  out.attributes.bits = from.attributes();
  require((out.attributes.bits & ~(AttributeSet::kAll | AttributeSet::kComputedNormal)) == 0,
          "an attribute is unknown");
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
  require(std::isfinite(out.max_error_model) && out.max_error_model >= 0, "an error is not a length");
  out.triangles_per_node = from.triangles_per_node();
  out.root_page = read(*from.root_page());
  require(out.root_page.number != 0, "a model has no root page");
  requireAtMost(out.root_page.bytes, kMaxPageBytes, "bytes in a root page");
  if (from.textures() != nullptr) {
    out.textures = read(*from.textures());
    require(out.textures.number != 0 && out.textures.bytes != 0, "a texture set has no blob");
    requireAtMost(out.textures.bytes, kMaxTextureSetBytes, "bytes in a texture set");
  }
  return out;
}

Offset<wire::RequestChange> write(Builder& builder, const RequestChange& change) {
  return wire::CreateRequestChange(builder, static_cast<uint8_t>(change.action),
                                   static_cast<uint8_t>(change.request_class), change.request, change.blob,
                                   change.priority_px);
}

RequestChange read(const wire::RequestChange& from) {
  require(from.action() <= static_cast<uint8_t>(RequestAction::kCancel), "an action on a request is unknown");
  require(from.request_class() <= static_cast<uint8_t>(RequestClass::kPrefetch),
          "a class of requests is unknown");
  require(from.request() != 0, "request 0 is reserved for unrequested blobs");
  require(!std::isnan(from.priority_px()), "a priority is not a number");
  return {static_cast<RequestAction>(from.action()), static_cast<RequestClass>(from.request_class()),
          from.request(), from.blob(), from.priority_px()};
}

// Messages in the order of their types: write() creates the table, read() fills the message from a table.

auto write(Builder& builder, const Hello& message) {
  const auto token = write(builder, checkText(message.token, kMaxTokenBytes, "bytes in a token"));
  const auto program = write(builder, sanitized(message.program));
  return wire::CreateHello(builder, message.min_version, message.max_version, message.features, token,
                           program);
}

void read(const wire::Hello& from, Hello& into) {
  into.min_version = from.min_version();
  into.max_version = from.max_version();
  require(into.min_version >= 1 && into.min_version <= into.max_version, "a range of versions is invalid");
  into.features = from.features();
  into.token = read(from.token(), kMaxTokenBytes, "bytes in a token");
  into.program = read(from.program(), kMaxStringBytes, "bytes in a program's name");
}

auto write(Builder& builder, const Welcome& message) {
  const auto program = write(builder, sanitized(message.program));
  return wire::CreateWelcome(builder, message.version, message.features, message.max_open_requests, program);
}

void read(const wire::Welcome& from, Welcome& into) {
  require(from.version() >= 1, "a version is zero");
  into = {from.version(), from.features(), from.max_open_requests(),
          read(from.program(), kMaxStringBytes, "bytes in a program's name")};
}

auto write(Builder& builder, const List&) { return wire::CreateList(builder); }

void read(const wire::List&, List&) {}

auto write(Builder& builder, const Models& message) {
  requireAtMost(message.models.size(), kMaxListedModels, "models in a list");
  std::vector<Offset<wire::ModelSummary>> models;
  models.reserve(message.models.size());
  for (const ModelSummary& summary : message.models) models.push_back(write(builder, summary));
  return wire::CreateModels(builder, builder.CreateVector(models));
}

void read(const wire::Models& from, Models& into) {
  if (from.models() == nullptr) return;
  requireAtMost(from.models()->size(), kMaxListedModels, "models in a list");
  into.models.reserve(from.models()->size());
  for (const wire::ModelSummary* summary : *from.models()) into.models.push_back(read(*summary));
}

auto write(Builder& builder, const Open& message) {
  const auto model = write(builder, checkText(message.model, kMaxModelNameBytes, "bytes in a model's name"));
  const wire::Digest known = write(message.known_build_id);
  const bool knows = message.known_build_id != Digest{};
  return wire::CreateOpen(builder, model, knows ? &known : nullptr);
}

void read(const wire::Open& from, Open& into) {
  into.model = read(from.model(), kMaxModelNameBytes, "bytes in a model's name");
  if (from.known_build_id() != nullptr) into.known_build_id = read(*from.known_build_id());
}

auto write(Builder& builder, const Opened& message) {
  const auto summary = write(builder, message.summary);
  return wire::CreateOpened(builder, message.handle, summary);
}

void read(const wire::Opened& from, Opened& into) {
  require(from.handle() != 0, "a model's handle is zero");
  into = {from.handle(), read(*from.summary())};
}

auto write(Builder& builder, const Requests& message) {
  requireAtMost(message.changes.size(), kMaxRequestsPerFrame, "requests in a frame");
  std::vector<Offset<wire::RequestChange>> changes;
  changes.reserve(message.changes.size());
  for (const RequestChange& change : message.changes) changes.push_back(write(builder, change));
  return wire::CreateRequests(builder, message.handle, builder.CreateVector(changes));
}

void read(const wire::Requests& from, Requests& into) {
  into.handle = from.handle();
  into.changes.clear();
  if (from.changes() == nullptr) return;
  requireAtMost(from.changes()->size(), kMaxRequestsPerFrame, "requests in a frame");
  into.changes.reserve(from.changes()->size());
  for (const wire::RequestChange* change : *from.changes()) into.changes.push_back(read(*change));
}

auto write(Builder& builder, const Credit& message) {
  return wire::CreateCredit(builder, message.granted_bytes);
}

void read(const wire::Credit& from, Credit& into) { into = {from.granted_bytes()}; }

auto write(Builder& builder, const Cancelled& message) {
  return wire::CreateCancelled(builder, message.request);
}

void read(const wire::Cancelled& from, Cancelled& into) { into = {from.request()}; }

auto write(Builder& builder, const ErrorMessage& message) {
  const auto text = write(builder, sanitized(message.message));
  return wire::CreateError(builder, static_cast<uint8_t>(message.code), message.request, message.closes,
                           text);
}

void read(const wire::Error& from, ErrorMessage& into) {
  const bool known = from.code() >= static_cast<uint8_t>(WireError::kMalformed) &&
                     from.code() <= static_cast<uint8_t>(WireError::kInternal);
  // A later version of the protocol may add codes. Unknown codes count as kInternal.
  into = {known ? static_cast<WireError>(from.code()) : WireError::kInternal, from.request(), from.closes(),
          read(from.message(), kMaxStringBytes, "bytes in an error's text")};
}

auto write(Builder& builder, const GoAway& message) {
  return wire::CreateGoAway(builder, write(builder, sanitized(message.reason)));
}

void read(const wire::GoAway& from, GoAway& into) {
  into = {read(from.reason(), kMaxStringBytes, "bytes in a reason")};
}

auto write(Builder& builder, const ModelReplaced& message) {
  return wire::CreateModelReplaced(builder, message.handle);
}

void read(const wire::ModelReplaced& from, ModelReplaced& into) { into = {from.handle()}; }

auto write(Builder& builder, const Ping& message) { return wire::CreatePing(builder, message.payload); }

void read(const wire::Ping& from, Ping& into) { into = {from.payload()}; }

auto write(Builder& builder, const Pong& message) { return wire::CreatePong(builder, message.payload); }

void read(const wire::Pong& from, Pong& into) { into = {from.payload()}; }

auto write(Builder& builder, const Close& message) { return wire::CreateClose(builder, message.handle); }

void read(const wire::Close& from, Close& into) { into = {from.handle()}; }

auto write(Builder& builder, const Closed& message) { return wire::CreateClosed(builder, message.handle); }

void read(const wire::Closed& from, Closed& into) { into = {from.handle()}; }

/// Maps a message to the generated type of its table.
template <typename Message>
struct TableOf;
#define LODE_MESSAGE(number, name, type) \
  template <>                            \
  struct TableOf<type> {                 \
    using Type = wire::name;             \
  };
LODE_MESSAGES(LODE_MESSAGE)
#undef LODE_MESSAGE

template <typename Message>
void readBody(std::span<const std::byte> body, Message& into) {
  using Table = typename TableOf<Message>::Type;
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
  require(!body.empty() && verifier.VerifyBuffer<Table>(nullptr), "its body is no FlatBuffer of its type");
  read(*flatbuffers::GetRoot<Table>(bytes), into);
}

}  // namespace

template <typename Message>
Bytes encode(const Message& message, uint32_t call) {
  size_t initial_bytes = kBuilderBytes;
  if constexpr (std::is_same_v<Message, Requests>) initial_bytes += 32 * message.changes.size();
  Builder builder(initial_bytes);
  builder.Finish(write(builder, message));
  requireAtMost(builder.GetSize(), kMaxFrameBodyBytes, "bytes in a frame's body");
  const auto header =
      encodeFrameHeader({builder.GetSize(), static_cast<uint8_t>(kFrameTypeOf<Message>), 0, call});
  Bytes frame(kFrameHeaderBytes + builder.GetSize());
  std::memcpy(frame.data(), header.data(), header.size());
  std::memcpy(frame.data() + header.size(), builder.GetBufferPointer(), builder.GetSize());
  return frame;
}

template <typename Message>
Message decode(std::span<const std::byte> body) {
  Message message;
  readBody(body, message);
  return message;
}

void decodeInto(std::span<const std::byte> body, Requests& into) { readBody(body, into); }

#define LODE_MESSAGE(number, name, type)              \
  template Bytes encode<type>(const type&, uint32_t); \
  template type decode<type>(std::span<const std::byte>);
LODE_MESSAGES(LODE_MESSAGE)
#undef LODE_MESSAGE

}  // namespace lode::proto
