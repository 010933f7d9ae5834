#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <memory_resource>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "proto/frame.h"
#include "proto/limits.h"
#include "proto/messages.h"
#include "server/serve/memory/memory_budget.h"
#include "server/serve/ops/metrics.h"
#include "server/serve/session/hold_clock.h"
#include "server/serve/session/model.h"
#include "server/serve/session/request_queue.h"
#include "server/serve/session/served_set.h"

namespace lode::serve {

using Clock = std::chrono::steady_clock;

struct SessionLimits {
  uint32_t max_open_requests = proto::kMaxOpenRequests;
  Clock::duration handshake = proto::kHandshakeDeadline;  ///< until Hello has come
  Clock::duration idle = proto::kIdleDeadline;            ///< between two frames of the client
  uint32_t max_open_models = proto::kMaxOpenModels;
};

/// What a session has from its owner, all of which outlives it.
struct SessionHost {
  const ServedSet* served = nullptr;   ///< as it is now; its owner may swap it
  MemoryAccount* memory = nullptr;     ///< open requests and queued answers are charged
  ThreadCounters* counters = nullptr;  ///< none: nothing is counted
  std::pmr::memory_resource* requests = std::pmr::get_default_resource();  ///< where open requests live
};

/// What an open model is taken to cost in memory, with the two blobs that follow unasked.
constexpr uint64_t kOpenModelBytes = 256;

/// A rest of a blob shorter than this, or this much of it, must fit in the window before a chunk is sent: a
/// window that opens in small steps shall not cut blobs to pieces (the silly window of RFC 1122, 4.2.3.4).
constexpr uint32_t kMinChunkBytes = 4096;

/// Piece of a blob that shall be sent next.
struct Chunk {
  const OpenedModel* opened = nullptr;  ///< as long as its request is open
  uint32_t blob = 0;
  uint32_t bytes = 0;
  uint32_t call = 0;
  uint64_t serial = 0;  ///< of its request
  proto::RequestClass request_class = proto::RequestClass::kVisible;
  Clock::time_point asked;
  Clock::duration held_before{};  ///< by the client, when it was asked
  proto::BlobChunkHeader header;

  bool first() const noexcept { return header.offset_bytes == 0; }
  bool last() const noexcept { return header.offset_bytes + bytes == header.total_bytes; }
};

/// The server's side of one connection, without sockets, files or clocks: frames go in, control frames and
/// chunks to send come out. It owns the requests' queue and the byte window. All memory is bounded: open
/// requests and models by the limits of proto/limits.h, control frames by what one frame can be answered
/// with, if the caller reads no further frame while controlBytes() is above a limit; and both are charged.
/// Not thread safe.
///
/// Order: everything of takeControl() goes out before a chunk begun after it was queued.
class Session {
 public:
  Session(SessionHost host, SessionLimits limits, Clock::time_point now);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Takes one frame of the client's. Whatever is wrong with it is answered, never thrown.
  void receive(const proto::FrameHeader& header, std::span<const std::byte> body, Clock::time_point now);
  /// Answers with an Error that closes the connection: for what is no frame at all.
  void refuse(proto::WireError code, const std::string& why, uint32_t call = 0);
  /// Says GoAway; the session is finished once no request is open and the client has heard it, as its Pong
  /// says or giveUpHearing(): what it requested before then is under way.
  void drain(const std::string& reason, Clock::time_point now);
  /// Waits no longer for the Pong than kHearDeadline. @return whether it gave up waiting now.
  bool giveUpHearing(Clock::time_point now) noexcept;
  /// Another served is made: says ModelReplaced of handles whose model has another build in it, and ends the
  /// session if its token is no longer good.
  void servedSetChanged();
  /// Ends the session if its token has expired.
  void checkExpiry(std::chrono::system_clock::time_point now);

  /// All control frames queued, in order. They stay charged: controlSent() when they are out.
  proto::Bytes takeControl() { return std::exchange(control_, {}); }
  void controlSent(size_t bytes) noexcept { host_.memory->give(bytes); }
  size_t controlBytes() const noexcept { return control_.size(); }

  /// The chunk to send next, the most urgent request's, if the window has room for it and no control frame
  /// waits. Until one of the functions below is called it is under way, and no other can begin.
  /// @param max_bytes  at most this much of the blob.
  std::optional<Chunk> beginChunk(uint32_t max_bytes = proto::kMaxChunkBytes);
  /// The chunk was read: it counts as sent. @return false if its request ended meanwhile; it must not be
  /// sent.
  bool finishChunk();
  /// As if it had never begun.
  void abandonChunk() noexcept { under_way_.reset(); }
  /// As if it had never begun, and its request is passed by until unpark().
  void parkChunk();
  /// @return false if the request has ended meanwhile.
  bool unpark(const Chunk& chunk);
  /// The blob cannot be read: its request ends with an Error.
  void failChunk(proto::WireError code, const std::string& why);

  /// No frame is taken any more; the connection closes once control frames are out.
  bool closing() const noexcept { return closing_; }
  /// Why, in the words that the client is told.
  const std::string& refusal() const noexcept { return refusal_; }
  /// Nothing is left to do but to send the control frames and close.
  bool finished() const noexcept { return closing_ || (draining_ && !hears_until_ && !wantsToSend()); }
  /// Blobs are to be sent, now or when the window opens or the disk has answered.
  bool wantsToSend() const noexcept { return !requests_.empty() || !unasked_.empty(); }
  /// A chunk could go out now but for the client's window.
  bool waitsForWindow();
  /// From now on the client takes no chunk, its window shut or its link full; and when it does again.
  void onBackpressure(Clock::time_point now) noexcept { held_.start(now); }
  void onWritable(Clock::time_point now) noexcept { held_.stop(now); }
  /// Of the time since a chunk's request came, what the client has held it up.
  Clock::duration heldSince(const Chunk& chunk, Clock::time_point now) const noexcept {
    return held_.total(now) - chunk.held_before;
  }
  /// When the connection must be given up unless another frame comes.
  Clock::time_point deadline() const noexcept { return deadline_; }
  bool greeted() const noexcept { return greeted_; }
  bool unauthorized() const noexcept { return unauthorized_; }
  size_t openRequests() const noexcept { return requests_.size(); }

 private:
  /// A blob that follows Opened, as request 0.
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
    uint32_t request;  ///< 0: the first unasked blob
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
  void answer(const Message& message, uint32_t call);
  template <typename Message>
  void say(const Message& message, uint32_t call);

  SessionHost host_;
  SessionLimits limits_;
  Clock::time_point deadline_;
  Clock::time_point now_;  ///< of the last frame
  bool greeted_ = false, closing_ = false, draining_ = false, unauthorized_ = false;
  std::optional<Clock::time_point> hears_until_;  ///< for the Pong that follows GoAway
  std::string token_, refusal_;
  std::shared_ptr<const TokenFile> tokens_;  ///< the file that grant_ lies in
  const TokenGrant* grant_ = nullptr;        ///< none: everything is allowed
  proto::Bytes control_;
  std::map<uint32_t, OpenedModel> opened_;  ///< by handle
  uint32_t last_handle_ = 0;
  std::deque<Unasked> unasked_;
  RequestQueue requests_;
  uint64_t last_serial_ = 0;
  HoldClock held_;
  std::optional<UnderWay> under_way_;
  uint64_t granted_bytes_ = proto::kInitialWindowBytes;
  uint64_t sent_bytes_ = 0;  ///< of Blob frame bodies
};

}  // namespace lode::serve
