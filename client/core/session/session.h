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
#include "common/codec/blob.h"
#include "common/codec/model_summary.h"
#include "common/error.h"
#include "proto/frame.h"
#include "proto/limits.h"
#include "proto/messages.h"

namespace lode::core {

constexpr std::chrono::seconds kPingInterval{10};    ///< server silence after which the session sends a Ping
constexpr std::chrono::seconds kMeasureInterval{1};  ///< interval between Pings while requests are open
/// Server silence after which the connection counts as lost.
constexpr std::chrono::seconds kSilenceLimit{30};
/// Longest time between two calls that counts as server silence. If the caller pauses for longer, received
/// bytes may be waiting to be passed in.
constexpr std::chrono::seconds kMaxGap{2};
/// Largest total size of the requested blobs; a single blob may be larger.
constexpr uint64_t kMaxRequestedBytes = 32ull << 20;
/// Largest number of open requests that are not cancelled: enough to fill any window, but few enough to sort
/// often.
constexpr uint32_t kMaxRequestsAtOnce = 1024;
/// Largest number of open requests, including cancelled requests that are not acknowledged yet.
constexpr size_t kMaxUnendedRequests = 16'384;
/// Largest number of bytes kept for cancelled requests; the session discards any further bytes.
constexpr uint64_t kMaxCancelledBytes = 4ull << 20;
constexpr float kReprioritiseFactor = 1.19f;  ///< 2^1/4; smaller changes of a priority are not sent

struct SessionOptions {
  std::string model;      ///< name of the model to open; if empty, the session lists the models instead
  Digest known_build_id;  ///< build of the model that the client has loaded; zeros for none
  std::string token;
  std::string program = "lodestream";
  uint64_t max_requested_bytes = kMaxRequestedBytes;
  /// Time from the first attempt during which a Connection retries even if the model has never been open. If
  /// zero, the first error is final.
  std::chrono::nanoseconds open_patience{0};
  /// If the server does not have the model, the session waits for the model instead of failing.
  bool awaits_model = false;
  /// Returns true if the bytes match the blob's digest. If unset, the session computes the digest of the
  /// bytes itself.
  std::function<bool(const BlobRef&, std::span<const std::byte>)> matches_digest;
};

struct ModelOpened {
  ModelSummary summary;
};
struct ModelsListed {
  std::vector<ModelSummary> models;
};
/// A blob has arrived completely, and its bytes match the digest.
struct BlobArrived {
  BlobRef blob;
  BlobUse use;
  std::vector<std::byte> bytes;
};
/// The server cannot send the blob.
struct BlobRefused {
  BlobRef blob;
  BlobUse use;
  std::string message;
  bool is_lost = false;  ///< the server does not have the blob; if false, a later request may succeed
};
/// A cancelled request has ended without its blob; the blob may be requested again.
struct RequestCancelled {
  BlobRef blob;
};
/// The server is shutting down or rejects the session for now: connect again later.
struct ServerLeaving {
  std::string reason;             ///< reason, worded for users
  Remedy remedy = Remedy::kNone;  ///< remedy that the text leaves to the program
};
struct ModelChanged {};
using SessionEvent = std::variant<ModelOpened, ModelsListed, BlobArrived, BlobRefused, RequestCancelled,
                                  ServerLeaving, ModelChanged>;

/// The client side of the protocol as a state machine without a socket. The caller passes in received bytes,
/// and gets events and bytes to send. The session validates all input and throws Error kProtocol, kLimit or
/// kFormat for a violation; do not use the session after that. Allocates memory only for blobs that the
/// client expects, whose sizes are known in advance. Processes no frames while more than
/// proto::kMaxQueuedAnswerBytes of Pongs wait in takeOutgoing(). Otherwise a server that sends Pings but
/// reads nothing could fill the client's memory. Not thread safe.
class Session {
 public:
  Session(SessionOptions options, TimePoint now);

  /// Takes received bytes, which may end inside a frame. Afterwards call nextEvent() until it returns
  /// nothing. Requires takesInput(), unless `bytes` is empty.
  void receive(std::span<const std::byte> bytes, TimePoint now);
  /// Processes the received bytes up to the next event. @throws Error kProtocol, kLimit or kFormat for a
  /// violation of the protocol; kInput or kNetwork with the server's message if the server refuses the
  /// session or the model.
  std::optional<SessionEvent> nextEvent();
  /// Returns false while received frames wait because too many Pongs are unsent. Then call takeOutgoing() as
  /// soon as the transport has room, and nextEvent() afterwards.
  bool takesInput() const noexcept { return !paused_; }

  /// Tells the session which blob the server sends next without a request (with request number 0). The
  /// session already expects the root page. After reading it, the caller names the payload of the root's
  /// coarsest LOD.
  void expectUnasked(const BlobRef& blob, const BlobUse& use);

  /// Replaces the set of requests: adds new ones, updates changed priorities, and cancels those that are not
  /// in `wanted`. Omits requests beyond the session's limits, and requests for blobs whose cancellation is
  /// not acknowledged yet; pass them again in a later call. Of the limits, only kMaxUnendedRequests counts
  /// cancelled requests too, because the server reads cancellations before additions.
  /// @param wanted  requests, best first.
  /// @return false if the call had no effect because too many frames wait in takeOutgoing(): call again
  /// later.
  bool setRequests(std::span<const Request> wanted);

  /// Keeps the connection alive in both directions. @throws Error kTimeout if no byte arrives, or no answer
  /// can be sent, for kSilenceLimit: see kMaxGap.
  void tick(TimePoint now);

  /// Returns the queued frames in order. The first call returns Hello, followed by Open or List.
  proto::Bytes takeOutgoing();

  /// Returns true if the server sends the root page and the root's coarsest LOD without a request, because
  /// the client has not loaded this build. Returns false once the server has refused one of the two blobs.
  bool givesFirstBlobs() const noexcept { return gives_first_blobs_; }
  bool opened() const noexcept { return state_ == State::kOpen; }
  bool isRequested(const BlobRef& blob) const { return request_of_blob_.contains(blob.number); }
  /// Returns the number of open requests, including cancelled requests that are not acknowledged yet.
  size_t openRequests() const noexcept { return requests_.size(); }
  /// Returns the numbers of open requests by class.
  const RequestCounts& requestCounts() const noexcept { return request_counts_; }
  uint64_t requestedBytes() const noexcept { return requested_bytes_; }
  /// Returns the number of bytes received from the transport.
  uint64_t receivedBytes() const noexcept { return received_bytes_; }
  /// Returns the measurements of the link and the flow control window.
  const CreditWindow& window() const noexcept { return window_; }

 private:
  enum class State { kWelcome, kAnswer, kOpen, kListed };
  struct Incoming {
    BlobRef blob;
    BlobUse use;
    // Bytes received so far; the first chunk reserves memory for the whole blob. Empty if is_dropped.
    std::vector<std::byte> bytes = {};
    uint32_t received_bytes = 0;
    bool is_dropped = false;  // the request is cancelled, and the session discards its bytes to save memory
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
  void handlePing(const proto::FrameHeader& header, std::span<const std::byte> body);
  void handlePong(std::span<const std::byte> body);
  void handleRefusal(const proto::ErrorMessage& error);
  Incoming endRequest(uint32_t request);
  void countRequest(const OpenRequest& request, bool is_open);
  bool hasUnsentAnswers() const noexcept { return answer_bytes_ > proto::kMaxQueuedAnswerBytes; }
  bool awaitsBlobs() const noexcept { return !requests_.empty() || unasked_; }
  uint64_t bytesOfUnfinishedFrame() const;
  void grantCredit();
  void sendCredit();
  void advance(TimePoint now);
  void send(const proto::Bytes& frame);
  void sendPing();
  void sendChanges(std::span<const proto::RequestChange> changes);
  void appendChunk(Incoming& incoming, const proto::BlobChunk& chunk);
  void cancel(OpenRequest& request);
  void limitCancelledBytes(OpenRequest& request);
  SessionEvent completed(Incoming incoming);

  SessionOptions options_;
  State state_ = State::kWelcome;
  uint32_t handle_ = 0;
  bool gives_first_blobs_ = false;
  uint32_t max_open_requests_ = 0;
  uint32_t next_call_ = 1;
  uint32_t next_request_ = 1;
  std::map<uint32_t, OpenRequest> requests_;                // by request number
  std::unordered_map<uint32_t, uint32_t> request_of_blob_;  // request number by blob number
  RequestCounts request_counts_;
  uint64_t requested_bytes_ = 0;  // total size of the requested blobs, without cancelled requests
  uint64_t cancelled_bytes_ = 0;  // number of bytes kept for cancelled requests
  std::optional<Incoming> unasked_;
  uint64_t granted_bytes_;
  uint64_t sent_grant_bytes_;    // last grant that takeOutgoing() returned; the server may use it
  uint64_t credited_bytes_ = 0;  // total size of the bodies of received Blob frames
  uint64_t received_bytes_ = 0;
  TimePoint now_, last_sent_, last_ping_;
  std::chrono::nanoseconds silence_{0};  // duration of the server's silence: see kMaxGap
  // Duration for which input has been paused since the last takeOutgoing().
  std::chrono::nanoseconds blocked_{0};
  CreditWindow window_;
  uint64_t pings_ = 0;
  bool ping_open_ = false;
  std::vector<std::byte> input_;  // received bytes that are not processed yet
  size_t input_begin_ = 0;
  bool paused_ = false;  // frames in input_ wait until takeOutgoing() takes the queued Pongs
  std::optional<SessionEvent> event_;
  proto::Bytes outgoing_;
  size_t answer_bytes_ = 0;  // bytes of Pongs in outgoing_
};

}  // namespace lode::core
