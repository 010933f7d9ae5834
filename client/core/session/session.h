#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <variant>
#include <vector>

#include "client/core/lod/request.h"
#include "client/core/session/credit_window.h"
#include "client/core/session/remedies.h"
#include "common/codec/blob.h"
#include "common/codec/model_summary.h"
#include "proto/frame.h"
#include "proto/messages.h"

namespace lode::core {

constexpr std::chrono::seconds kPingInterval{10};    ///< of silence, after which a Ping is sent
constexpr std::chrono::seconds kMeasureInterval{1};  ///< between Pings while blobs are awaited
constexpr std::chrono::seconds kSilenceLimit{30};    ///< after which the server counts as gone
constexpr std::chrono::seconds kLongestPause{2};  ///< between two calls that counts as silence of the server
constexpr uint64_t kMaxRequestedBytes = 32ull
                                        << 20;  ///< of open requests together, unless one alone is larger
constexpr uint32_t kMaxRequestsAtOnce = 1024;   ///< enough to fill any window, few enough to re-sort
constexpr float kReprioritiseFactor = 1.19f;    ///< 2^1/4: smaller changes of priority are not sent

struct SessionOptions {
  std::string model;      ///< empty: asks for the list of models and opens none
  Digest known_build_id;  ///< of the model as the client knows it; zeros for none
  std::string token;
  std::string program = "lodestream";
  Remedies remedies;
  uint64_t max_requested_bytes = kMaxRequestedBytes;
  /// That the server does not have the model is taken for one that is leaving: it may have it again.
  bool awaits_model = false;
  /// Whether bytes have the blob's name; none: their SHA-256 is compared with it.
  std::function<bool(const BlobRef&, std::span<const std::byte>)> matches_digest;
};

struct ModelOpened {
  ModelSummary summary;
};
struct ModelsListed {
  std::vector<ModelSummary> models;
};
/// A blob is complete, and its bytes have the announced name.
struct BlobArrived {
  BlobRef blob;
  BlobUse use;
  std::vector<std::byte> bytes;
};
/// The server cannot give the blob.
struct BlobRefused {
  BlobRef blob;
  BlobUse use;
  std::string message;
  bool is_lost = false;  ///< the server does not have it; else it may give it another time
};
/// A request that was taken back has ended without its blob, which may be requested again from now on.
struct RequestCancelled {
  BlobRef blob;
};
/// The server closes, for now: connect again.
struct ServerLeaving {
  std::string reason;  ///< for people
};
struct ModelChanged {};
using SessionEvent = std::variant<ModelOpened, ModelsListed, BlobArrived, BlobRefused, RequestCancelled,
                                  ServerLeaving, ModelChanged>;

/// One side of a conversation with a server, without a socket: bytes in, events out, bytes out. Everything
/// that comes in is checked; what the protocol does not allow throws Error kProtocol (kLimit, kFormat), and
/// the session must be given up. Memory for incoming blobs is taken only for blobs that were requested,
/// whose size was known before. Not thread safe.
class Session {
 public:
  Session(SessionOptions options, TimePoint now);

  /// Takes bytes as they come from the transport, cut anywhere. Call nextEvent() until it is empty
  /// afterwards.
  void receive(std::span<const std::byte> bytes, TimePoint now);
  /// Works through what was received up to the next event. @throws Error as above; kNetwork with the server's
  /// words if it refused the session or the model.
  std::optional<SessionEvent> nextEvent();

  /// The next unasked blob (request 0) that the server sends: the root's page is expected by itself, the
  /// root's coarsest payload is named by who reads the page.
  void expectUnasked(const BlobRef& blob, const BlobUse& use);

  /// What the client wants now, best first: requests what is new, re-prioritises, and cancels the rest.
  /// What goes beyond the limits of the session is left for a later call; so is what is wanted again while
  /// its cancel is under way, until the RequestCancelled or the blob that ends it. Requests taken back count
  /// in no limit: the server reads the cancels before the adds.
  void setRequests(std::span<const Request> wanted);

  /// Keeps the connection alive in both directions. @throws Error kTimeout after kSilenceLimit without a
  /// byte. Time in which nobody called counts as kLongestPause: what came then waits to be received.
  void tick(TimePoint now);

  /// Frames to be sent, in order; the first call gives Hello and Open (or List) together.
  proto::Bytes takeOutgoing();

  /// The server sends the root's page and its coarsest LOD by itself: it does to who knows another build.
  bool givesFirstBlobs() const noexcept { return gives_first_blobs_; }
  bool opened() const noexcept { return state_ == State::kOpen; }
  bool isRequested(const BlobRef& blob) const { return request_of_blob_.contains(blob.number); }
  size_t openRequests() const noexcept { return requests_.size(); }                ///< those taken back, too
  const RequestCounts& requestCounts() const noexcept { return request_counts_; }  ///< of the same
  uint64_t requestedBytes() const noexcept { return requested_bytes_; }
  uint64_t receivedBytes() const noexcept { return received_bytes_; }  ///< all that came from the transport
  /// What is known of the link, and what the server may have under way because of that.
  const CreditWindow& window() const noexcept { return window_; }

 private:
  enum class State { kWelcome, kAnswer, kOpen, kListed };
  struct Incoming {
    BlobRef blob;
    BlobUse use;
    std::vector<std::byte> bytes;  // received so far; room for all of it is taken with the first chunk
  };
  struct OpenRequest {
    Incoming incoming;
    proto::RequestClass request_class = proto::RequestClass::kVisible;
    float priority_px = 0;
    bool cancelling = false;
  };

  proto::FrameHeader headerOf(std::span<const std::byte, proto::kFrameHeaderBytes> bytes) const;
  bool takeFrame();
  void handleFrame(const proto::FrameHeader& header, std::span<const std::byte> body);
  void handleWelcome(const proto::FrameHeader& header, std::span<const std::byte> body);
  void handleOpened(const proto::FrameHeader& header, std::span<const std::byte> body);
  void handleModels(const proto::FrameHeader& header, std::span<const std::byte> body);
  void handleBlob(std::span<const std::byte> body);
  void handleCancelled(std::span<const std::byte> body);
  void handleError(std::span<const std::byte> body);
  void handlePong(std::span<const std::byte> body);
  void handleRefusal(const proto::ErrorMessage& error);
  void endRequest(uint32_t request);
  void countRequest(const OpenRequest& request, bool is_open);
  bool awaitsBlobs() const noexcept { return !requests_.empty() || unasked_; }
  uint64_t bytesOfUnfinishedFrame() const;
  void grantCredit();
  void sendCredit();
  void pass(TimePoint now);
  void send(const proto::Bytes& frame);
  void sendPing();
  void sendChanges(std::span<const proto::RequestChange> changes);
  void appendChunk(Incoming& incoming, const proto::BlobChunk& chunk);
  SessionEvent completed(Incoming incoming);

  SessionOptions options_;
  State state_ = State::kWelcome;
  uint32_t handle_ = 0;
  bool gives_first_blobs_ = false;
  uint32_t max_open_requests_ = 0;
  uint32_t next_call_ = 1;
  uint32_t next_request_ = 1;
  std::map<uint32_t, OpenRequest> requests_;                // by request
  std::unordered_map<uint32_t, uint32_t> request_of_blob_;  // blob number -> request
  RequestCounts request_counts_;
  uint64_t requested_bytes_ = 0;  // of requests that are not taken back
  std::optional<Incoming> unasked_;
  uint64_t granted_bytes_;
  uint64_t sent_grant_bytes_;    // what the server can know of: handed out by takeOutgoing()
  uint64_t credited_bytes_ = 0;  // received bodies of Blob frames
  uint64_t received_bytes_ = 0;
  TimePoint now_, last_sent_, last_ping_;
  std::chrono::nanoseconds silence_{0};  // of the server, while it was listened to
  CreditWindow window_;
  uint64_t pings_ = 0;
  bool ping_open_ = false;
  std::vector<std::byte> input_;  // received, not worked through
  size_t input_begin_ = 0;
  std::optional<SessionEvent> event_;
  proto::Bytes outgoing_;
};

}  // namespace lode::core
