#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "proto/frame.h"
#include "proto/limits.h"
#include "proto/messages.h"
#include "server/serve/memory/memory_budget.h"
#include "server/serve/ops/metrics.h"
#include "server/serve/session/catalog.h"
#include "server/serve/session/request_queue.h"

namespace lode::serve {

using Clock = std::chrono::steady_clock;

struct SessionLimits {
  uint32_t max_open_requests = proto::kMaxOpenRequests;
  Clock::duration handshake = proto::kHandshakeDeadline;  ///< time from the connection to Hello
  Clock::duration idle = proto::kIdleDeadline;            ///< time from one frame of the client to the next
  uint32_t max_open_models = proto::kMaxOpenModels;
};

/// Objects that a session uses. All of them must outlive the session.
struct SessionHost {
  /// Models and tokens; the owner calls servedSetChanged() after replacing them.
  const ServedSet* served = nullptr;
  MemoryAccount* memory = nullptr;     ///< account for open requests, open models and queued answers
  ThreadCounters* counters = nullptr;  ///< counters of the thread, or null to count nothing
};

/// Memory charged for an open model and the two blobs that follow Opened.
constexpr uint64_t kOpenModelBytes = 256;

/// Smallest size of a chunk, unless the rest of the blob is shorter. The session sends a chunk only if the
/// window has room for this size. Otherwise, a window that opens in small steps would cause tiny chunks
/// (silly window syndrome, RFC 1122, 4.2.3.4).
constexpr uint32_t kMinChunkBytes = 4096;

/// Measures the total time under backpressure.
class BackpressureClock {
 public:
  void start(Clock::time_point now) noexcept {
    if (!since_) since_ = now;
  }
  void stop(Clock::time_point now) noexcept {
    if (since_) before_ += now - *since_;
    since_.reset();
  }
  Clock::duration total(Clock::time_point now) const noexcept {
    return since_ ? before_ + (now - *since_) : before_;
  }

 private:
  Clock::duration before_{};
  std::optional<Clock::time_point> since_;  ///< start of the current backpressure
};

/// The part of a blob to send next.
struct Chunk {
  const OpenedModel* opened = nullptr;  ///< valid while the request of the chunk is open
  uint32_t blob = 0;
  uint32_t bytes = 0;
  uint32_t call = 0;
  uint64_t serial = 0;  ///< OpenRequest::serial of the chunk's request
  proto::RequestClass request_class = proto::RequestClass::kVisible;
  Clock::time_point asked;
  Clock::duration held_before{};  ///< backpressure time when the request arrived
  proto::BlobChunkHeader header;

  bool first() const noexcept { return header.offset_bytes == 0; }
  bool last() const noexcept { return header.offset_bytes + bytes == header.total_bytes; }
};

/// Protocol state of one connection on the server, without sockets, files or clocks. The session receives
/// frames and produces the control frames and chunks to send. The session owns the request queue and the byte
/// window. All memory is charged and bounded. SessionLimits bounds open requests and models. The caller
/// bounds the queued control frames: if the caller reads no frame while controlBytes() is above a limit, the
/// queue exceeds this limit by at most the answers to one frame. Not thread safe.
///
/// The caller sends queued control frames before it begins another chunk.
class Session {
 public:
  Session(SessionHost host, SessionLimits limits, Clock::time_point now);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Handles a frame of the client. Answers a mistake with an Error frame instead of an exception.
  void receive(const proto::FrameHeader& header, std::span<const std::byte> body, Clock::time_point now);
  /// Queues an Error that closes the connection, for input that is not a frame.
  void refuse(proto::WireError code, const std::string& why, uint32_t call = 0);
  /// Queues GoAway and a Ping; before Hello, queues only GoAway. Serves the requests that arrive before the
  /// Pong. The session is finished when no request is open and either the Pong has arrived or
  /// stopWaitingForPong() has returned true.
  void drain(const std::string& reason, Clock::time_point now);
  /// Stops waiting for the Pong if kHearDeadline has passed. @return true if this call stopped the wait.
  bool stopWaitingForPong(Clock::time_point now) noexcept;
  /// Handles a change of SessionHost::served. Queues ModelReplaced for handles whose model has a new build,
  /// and ends the session if its token is no longer valid.
  void servedSetChanged();
  /// Ends the session if its token has expired.
  void checkExpiry(std::chrono::system_clock::time_point now);

  /// Moves out all queued control frames in order. Their memory stays charged until controlSent().
  proto::Bytes takeControl() { return std::exchange(control_, {}); }
  void controlSent(size_t bytes) noexcept { host_.memory->give(bytes); }
  size_t controlBytes() const noexcept { return control_.size(); }

  /// Begins the next chunk of the most urgent request, if the window has room and no control frame is queued.
  /// End the chunk with finishChunk(), abandonChunk(), parkChunk() or failChunk() before you begin another
  /// one.
  /// @param max_bytes  maximum size of the chunk.
  std::optional<Chunk> beginChunk(uint32_t max_bytes = proto::kMaxChunkBytes);
  /// Counts the chunk as sent. @return false if the request of the chunk has ended, so that the caller must
  /// not send the chunk.
  bool finishChunk();
  /// Undoes beginChunk().
  void abandonChunk() noexcept { under_way_.reset(); }
  /// Undoes beginChunk() and skips the request until unpark().
  void parkChunk();
  /// Undoes parkChunk(), so that beginChunk() can choose the request again. @return false if the request has
  /// ended.
  bool unpark(const Chunk& chunk);
  /// Ends the chunk's request with an Error because the blob cannot be read.
  void failChunk(proto::WireError code, const std::string& why);

  /// Returns true after an Error that closes the connection. The session then ignores received frames, but
  /// still sends control frames.
  bool closing() const noexcept { return closing_; }
  /// Returns the message of the Error that closes the connection.
  const std::string& refusal() const noexcept { return refusal_; }
  /// Returns true if only control frames are left to send before the connection closes.
  bool finished() const noexcept { return closing_ || (draining_ && !pong_deadline_ && !wantsToSend()); }
  /// Returns true if blobs are left to send, even if they wait for the window or for the disk.
  bool wantsToSend() const noexcept { return !requests_.empty() || !unasked_.empty(); }
  /// Returns true if a chunk is ready and waits only for room in the client's window.
  bool waitsForWindow();
  /// Notes the start of backpressure; onWritable() notes the end. Under backpressure the client cannot
  /// receive a chunk, because its window has no room or its link is full.
  void onBackpressure(Clock::time_point now) noexcept { held_.start(now); }
  void onWritable(Clock::time_point now) noexcept { held_.stop(now); }
  /// Returns the time under backpressure since the chunk's request arrived.
  Clock::duration heldSince(const Chunk& chunk, Clock::time_point now) const noexcept {
    return held_.total(now) - chunk.held_before;
  }
  /// Returns the time at which the connection ends if no frame arrives until then.
  Clock::time_point deadline() const noexcept { return deadline_; }
  bool greeted() const noexcept { return greeted_; }
  bool unauthorized() const noexcept { return unauthorized_; }
  /// Returns true if Hello was refused for its token, which was not empty.
  bool gaveWrongToken() const noexcept { return unauthorized_ && !greeted_ && !token_.empty(); }
  size_t openRequests() const noexcept { return requests_.size(); }

 private:
  /// A blob that follows Opened without a request. The session sends it as request 0.
  struct Unasked {
    uint32_t handle = 0;
    const OpenedModel* opened = nullptr;
    uint32_t blob = 0, sent_bytes = 0, call = 0;
    uint64_t serial = 0;
    Clock::time_point asked;
    Clock::duration held_before{};
    bool parked = false;
  };
  struct UnderWay {
    uint32_t request;  ///< id of the request; 0 for the first unasked blob
    uint32_t bytes;
    bool last;
  };

  void dispatch(const proto::FrameHeader& header, std::span<const std::byte> body);
  void hello(const proto::Hello& message, uint32_t call);
  bool authorize();
  bool allows(const Model& model) const noexcept;
  void list(uint32_t call);
  void open(const proto::Open& message, uint32_t call);
  void close(const proto::Close& message, uint32_t call);
  void requests(std::span<const std::byte> body, uint32_t call);
  void addRequest(const proto::RequestChange& change, uint32_t handle, const OpenedModel& opened,
                  uint32_t call);
  void endRequest(OpenRequest& request);
  std::optional<Chunk> next();
  uint64_t window() const noexcept;
  const OpenedModel& openedAs(uint32_t handle, const char* frame);
  template <typename Message>
  void queue(const Message& message, uint32_t call);
  template <typename Message>
  void queueUnchecked(const Message& message, uint32_t call);

  SessionHost host_;
  SessionLimits limits_;
  Clock::time_point deadline_;
  Clock::time_point now_;  ///< time of the last frame
  bool greeted_ = false, closing_ = false, draining_ = false, unauthorized_ = false;
  std::optional<Clock::time_point> pong_deadline_;  ///< set while the session waits for the Pong after GoAway
  std::string token_, refusal_;
  /// Token file in which authorize() last looked up the token; owns grant_.
  std::shared_ptr<const TokenFile> tokens_;
  /// Rights of the client's token; null allows all models.
  const TokenGrant* grant_ = nullptr;
  proto::Bytes control_;
  std::map<uint32_t, OpenedModel> opened_;  ///< open models by handle
  uint32_t last_handle_ = 0;
  std::deque<Unasked> unasked_;
  RequestQueue requests_;
  uint64_t last_serial_ = 0;
  BackpressureClock held_;
  std::optional<UnderWay> under_way_;
  uint64_t granted_bytes_ = proto::kInitialWindowBytes;
  uint64_t sent_bytes_ = 0;  ///< total size of the Blob frame bodies sent so far
};

}  // namespace lode::serve
