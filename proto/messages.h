#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/codec/model_summary.h"
#include "proto/frame.h"
#include "proto/limits.h"

/// The messages as plain structs. On the wire, bodies of messages are the FlatBuffers tables of
/// lodestream.fbs. docs/protocol.md describes the meaning of each message. A new message needs a line in
/// LODE_MESSAGES (frame.h), a table in lodestream.fbs, a struct here and a write() and a read() in
/// messages.cpp.
namespace lode::proto {

using Bytes = std::vector<std::byte>;

struct Hello {
  uint32_t min_version = kProtocolVersion, max_version = kProtocolVersion;
  uint64_t features = 0;
  std::string token, program;
  bool operator==(const Hello&) const = default;
};

struct Welcome {
  uint32_t version = kProtocolVersion;
  uint64_t features = 0;
  uint32_t max_open_requests = 0;
  std::string program;
  bool operator==(const Welcome&) const = default;
};

struct List {
  bool operator==(const List&) const = default;
};

struct Models {
  std::vector<ModelSummary> models;
  bool operator==(const Models&) const = default;
};

struct Open {
  std::string model;
  Digest known_build_id;  ///< build in the client's cache; zeros if the cache has no build
  bool operator==(const Open&) const = default;
};

/// Answers Open. The blobs of the root's page and of the root's coarsest LOD follow without a request, with
/// request number 0.
struct Opened {
  uint32_t handle = 0;
  ModelSummary summary;
  bool operator==(const Opened&) const = default;
};

enum class RequestClass : uint8_t { kVisible = 0, kMargin = 1, kPrefetch = 2 };
enum class RequestAction : uint8_t { kAdd = 0, kReprioritise = 1, kCancel = 2 };

struct RequestChange {
  RequestAction action = RequestAction::kAdd;
  RequestClass request_class = RequestClass::kVisible;
  /// Number above 0 that the client chooses; unique among the session's open requests.
  uint32_t request = 0;
  uint32_t blob = 0;      ///< number of the blob in the model's store; used by kAdd only
  float priority_px = 0;  ///< projected error; within a class, the highest priority is served first
  bool operator==(const RequestChange&) const = default;
};

/// Adds, changes or cancels requests. Each added request ends exactly once: with the last chunk of its blob,
/// with Cancelled, or with Error.
struct Requests {
  uint32_t handle = 0;
  std::vector<RequestChange> changes;
  bool operator==(const Requests&) const = default;
};

/// Sets the number of bytes in bodies of Blob frames that the server may send in total, counted from the
/// start of the session.
struct Credit {
  uint64_t granted_bytes = 0;
  bool operator==(const Credit&) const = default;
};

struct Cancelled {
  uint32_t request = 0;
  bool operator==(const Cancelled&) const = default;
};

enum class WireError : uint8_t {
  kMalformed = 1,
  kUnknownFrame = 2,
  kVersion = 3,
  kUnauthorized = 4,
  kNoSuchModel = 5,
  kNoSuchBlob = 6,
  kLimit = 7,
  kDamagedStore = 8,
  kNotReady = 9,
  kInternal = 10,
};

struct ErrorMessage {
  WireError code = WireError::kInternal;
  uint32_t request = 0;  ///< request that the error ends; 0 if the error answers a frame
  bool closes = false;   ///< the server closes the connection after this error
  std::string message;
  bool operator==(const ErrorMessage&) const = default;
};

struct GoAway {
  std::string reason;
  bool operator==(const GoAway&) const = default;
};

struct ModelReplaced {
  uint32_t handle = 0;
  bool operator==(const ModelReplaced&) const = default;
};

struct Ping {
  uint64_t payload = 0;
  bool operator==(const Ping&) const = default;
};

struct Pong {
  uint64_t payload = 0;
  bool operator==(const Pong&) const = default;
};

/// Closes a model. The server ends the model's open requests with Cancelled, then answers Closed.
struct Close {
  uint32_t handle = 0;
  bool operator==(const Close&) const = default;
};

struct Closed {
  uint32_t handle = 0;
  bool operator==(const Closed&) const = default;
};

/// Frame type of a message. For example, kFrameTypeOf<Hello> is FrameType::kHello.
template <typename Message>
constexpr FrameType kFrameTypeOf = FrameType::kBlob;
#define LODE_MESSAGE(number, name, type) \
  template <>                            \
  inline constexpr FrameType kFrameTypeOf<type> = FrameType::k##name;
LODE_MESSAGES(LODE_MESSAGE)
#undef LODE_MESSAGE

/// Encodes any message of LODE_MESSAGES as a whole frame, header included. Cuts texts that only people read
/// (reasons, errors, names of programs) to the limit, and replaces their unprintable characters. Thread safe.
/// @throws Error kProtocol or kLimit if a model's name, a token or a list is invalid or exceeds a limit.
template <typename Message>
Bytes encode(const Message& message, uint32_t call);

/// Decodes a frame's body from an untrusted peer: decode<Hello>(body). Thread safe.
/// @throws Error kProtocol or kLimit.
template <typename Message>
Message decode(std::span<const std::byte> body);
/// Decodes the body of a Requests frame and reuses the memory of `into`.
void decodeInto(std::span<const std::byte> body, Requests& into);

}  // namespace lode::proto
