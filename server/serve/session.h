#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/model_summary.h"
#include "proto/frame.h"
#include "proto/limits.h"
#include "proto/messages.h"

namespace lode::serve {

/// What a session must know of a model; the bytes of its blobs are somebody else's.
struct OfferedModel {
  ModelSummary summary;
  std::vector<uint32_t> blob_bytes;  ///< size of each blob by number; 0 is no blob
  uint32_t coarsest_blob = 0;        ///< the root's coarsest rung; 0 if it has no triangles

  uint32_t blobBytes(uint32_t number) const noexcept {
    return number < blob_bytes.size() ? blob_bytes[number] : 0;
  }
};

using Clock = std::chrono::steady_clock;

struct SessionLimits {
  uint32_t max_open_wishes = proto::kMaxOpenWishes;
  Clock::duration handshake = std::chrono::seconds(10);  ///< until Hello has come
  Clock::duration idle = std::chrono::seconds(120);      ///< between two frames of the client
};

/// A rest of a blob shorter than this, or this much of it, must fit in the window before a chunk is sent: a
/// window that opens in small steps shall not cut blobs to pieces (the silly window of RFC 1122, 4.2.3.4).
constexpr uint32_t kMinChunkBytes = 4096;

/// Piece of a blob that shall be sent next.
struct Chunk {
  uint32_t model = 0;  ///< index of the offered model
  uint32_t blob = 0;
  uint32_t bytes = 0;
  uint32_t request = 0;
  proto::BlobChunkHeader header;
};

/// The server's side of one connection, without sockets, files or clocks: frames go in, control frames and
/// chunks to send come out. It owns the wishes' queue and the byte window. All memory is bounded: open wishes
/// and models by the limits of proto/limits.h, control frames by what one frame can be answered with, if the
/// caller reads no further frame while controlBytes() is above kMaxQueuedControlBytes. Not thread safe.
///
/// Order: everything of takeControl() goes out before a chunk begun after it was queued.
class Session {
 public:
  /// @param models  outlive the session.
  Session(std::span<const OfferedModel> models, SessionLimits limits, Clock::time_point now);

  /// Takes one frame of the client's. Whatever is wrong with it is answered, never thrown.
  void receive(const proto::FrameHeader& header, std::span<const std::byte> body, Clock::time_point now);
  /// Answers with an Error that closes the connection: for what is no frame at all.
  void refuse(proto::WireError code, const std::string& why, uint32_t request = 0);
  /// Says GoAway; the session is finished once no wish is open.
  void drain(const std::string& reason);

  /// All control frames queued, in order.
  proto::Bytes takeControl() { return std::exchange(control_, {}); }
  size_t controlBytes() const noexcept { return control_.size(); }

  /// The chunk to send next, the most urgent wish's, if the window has room for it and no control frame
  /// waits. Until finishChunk(), abandonChunk() or failChunk() it is under way, and no other can begin.
  /// @param max_bytes  at most this much of the blob.
  std::optional<Chunk> beginChunk(uint32_t max_bytes = proto::kMaxChunkBytes);
  /// The chunk was read: it counts as sent. @return false if its wish ended meanwhile; it must not be sent.
  bool finishChunk();
  /// As if it had never begun.
  void abandonChunk() noexcept { under_way_.reset(); }
  /// The blob cannot be read: its wish ends with an Error.
  void failChunk(proto::WireError code, const std::string& why);

  /// No frame is taken any more; the connection closes once control frames are out.
  bool closing() const noexcept { return closing_; }
  /// Nothing is left to do but to send the control frames and close.
  bool finished() const noexcept { return closing_ || (draining_ && wishes_.empty() && unasked_.empty()); }
  /// When the connection must be given up unless another frame comes.
  Clock::time_point deadline() const noexcept { return deadline_; }
  bool greeted() const noexcept { return greeted_; }

 private:
  /// Where a wish stands in the queue: by class, then priority, then number.
  struct Rank {
    proto::WishClass wish_class;
    float priority_px;
    uint32_t wish;
    bool operator<(const Rank& other) const noexcept;
  };
  struct Wish {
    Rank rank;
    uint32_t model, blob, sent_bytes, request;
  };
  /// A blob that follows Opened, as wish 0.
  struct Unasked {
    uint32_t handle, model, blob, sent_bytes, request;
  };
  struct UnderWay {
    uint32_t wish;  ///< 0: the first unasked blob
    uint32_t bytes;
    bool last;
  };

  void dispatch(const proto::FrameHeader& header, std::span<const std::byte> body);
  void hello(const proto::Hello& message, uint32_t request);
  void open(const proto::Open& message, uint32_t request);
  void wishes(const proto::Wishes& message, uint32_t request);
  void addWish(const proto::WishChange& change, uint32_t model, uint32_t request);
  void endWish(std::unordered_map<uint32_t, Wish>::iterator wish);
  template <typename Message>
  void answer(const Message& message, uint32_t request);

  std::span<const OfferedModel> models_;
  SessionLimits limits_;
  Clock::time_point deadline_;
  bool greeted_ = false, closing_ = false, draining_ = false;
  proto::Bytes control_;
  std::vector<uint32_t> opened_;  ///< model of each handle; handle 1 is the first
  std::deque<Unasked> unasked_;
  std::unordered_map<uint32_t, Wish> wishes_;
  std::set<Rank> queue_;
  std::optional<UnderWay> under_way_;
  uint64_t granted_bytes_ = proto::kInitialWindowBytes;
  uint64_t sent_bytes_ = 0;  ///< of Blob frame bodies
};

/// The caller reads no further frame while more than this waits to be sent.
constexpr size_t kMaxQueuedControlBytes = 64u << 10;

}  // namespace lode::serve
