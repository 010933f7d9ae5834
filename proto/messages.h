#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/codec/model_summary.h"
#include "proto/frame.h"
#include "proto/limits.h"

/// The messages as plain structs, and their FlatBuffers bodies (proto/lodestream.fbs). Each encode function
/// gives a whole frame, header included. Each decode function takes a frame's body from an untrusted peer and
/// throws Error kProtocol or kLimit; all are thread safe.
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
  Digest known_build_id;  ///< zeros for none
  bool operator==(const Open&) const = default;
};

/// Followed, unasked, by the blobs of the root's page and of the root's coarsest LOD, both as request 0.
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
  uint32_t request = 0;   ///< chosen by the client, > 0, unique in the session while it is open
  uint32_t blob = 0;      ///< with kAdd: number of the blob in the model's store
  float priority_px = 0;  ///< within the class: projected error, higher first
  bool operator==(const RequestChange&) const = default;
};

/// Each request added has exactly one ending: its blob complete, Cancelled, or Error.
struct Requests {
  uint32_t handle = 0;
  std::vector<RequestChange> changes;
  bool operator==(const Requests&) const = default;
};

/// The server may have sent this many bytes of Blob frame bodies in all, since the session's start.
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
  uint32_t request = 0;  ///< the request that it ends; 0: it answers the frame with the call id
  bool closes = false;   ///< the connection closes after it
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

/// The client is done with a model. Its open requests end with Cancelled, then Closed comes.
struct Close {
  uint32_t handle = 0;
  bool operator==(const Close&) const = default;
};

struct Closed {
  uint32_t handle = 0;
  bool operator==(const Closed&) const = default;
};

/// Whether a string may be sent: UTF-8 without control characters (it may end up on a terminal). encode()
/// makes texts for people fit by itself; it throws Error kProtocol or kLimit for names and tokens that are
/// not.
bool isWireText(std::string_view text) noexcept;

Bytes encode(const Hello& message, uint32_t call);
Bytes encode(const Welcome& message, uint32_t call);
Bytes encode(const List& message, uint32_t call);
Bytes encode(const Models& message, uint32_t call);
Bytes encode(const Open& message, uint32_t call);
Bytes encode(const Opened& message, uint32_t call);
Bytes encode(const Requests& message, uint32_t call);
Bytes encode(const Credit& message, uint32_t call);
Bytes encode(const Cancelled& message, uint32_t call);
Bytes encode(const ErrorMessage& message, uint32_t call);
Bytes encode(const GoAway& message, uint32_t call);
Bytes encode(const ModelReplaced& message, uint32_t call);
Bytes encode(const Ping& message, uint32_t call);
Bytes encode(const Pong& message, uint32_t call);
Bytes encode(const Close& message, uint32_t call);
Bytes encode(const Closed& message, uint32_t call);

/// decode<Hello>(body) and so on, for every message above.
template <typename Message>
Message decode(std::span<const std::byte> body);
/// The same into a message that keeps its memory from call to call.
void decodeInto(std::span<const std::byte> body, Requests& into);

}  // namespace lode::proto
