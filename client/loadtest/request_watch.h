#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "client/core/session/session.h"
#include "client/core/view/time_point.h"
#include "proto/frame.h"
#include "proto/messages.h"

namespace lode::app {

/// Calls take(type, body) for each complete frame. @return the number of bytes in these frames.
/// @throws Error as proto::decodeFrameHeader().
template <typename Take>
size_t forEachFrame(std::span<const std::byte> bytes, const Take& take) {
  size_t at = 0;
  while (bytes.size() - at >= proto::kFrameHeaderBytes) {
    const auto header = proto::decodeFrameHeader(bytes.subspan(at).first<proto::kFrameHeaderBytes>());
    const size_t whole = proto::kFrameHeaderBytes + header.body_bytes;
    if (bytes.size() - at < whole) break;
    take(static_cast<proto::FrameType>(header.type),
         bytes.subspan(at + proto::kFrameHeaderBytes, header.body_bytes));
    at += whole;
  }
  return at;
}

/// Times the requests of one connection. Reads them from the frames that the client sends. Not thread safe.
class RequestClock {
 public:
  struct Request {
    uint32_t number;
    proto::RequestClass request_class;
    core::TimePoint sent;
  };

  /// Requests by blob number.
  using Requests = std::map<uint32_t, Request>;

  /// Notes the requests and cancellations in a sequence of complete frames.
  /// @param lost  requests of broken connections. A request that is sent again is removed from `lost` and
  /// keeps the time at which it was first sent.
  void sent(std::span<const std::byte> frames, core::TimePoint now, Requests& lost);
  /// Ends and returns the request of a blob that arrived. Returns nothing if the blob was not requested.
  std::optional<Request> arrived(uint32_t blob);
  /// Ends the request of a blob that the server refused.
  void refused(uint32_t blob) { arrived(blob); }
  /// Returns the open requests.
  const Requests& open() const noexcept { return open_; }

 private:
  Requests open_;
  std::map<uint32_t, uint32_t> blob_of_;  ///< blob number by request number
};

/// Largest number of requests of broken connections that a client remembers.
constexpr size_t kMaxLostRequests = 4096;

/// Adds the requests of a broken connection to `lost`, up to kMaxLostRequests in total. @return the requests
/// for which there is no room.
RequestClock::Requests addLost(RequestClock::Requests& lost, RequestClock::Requests more);

/// Observes both directions of a client's connection and reports each request when its blob is complete.
/// Throws on protocol errors. Not thread safe.
class OverheardRequests {
 public:
  /// Called with each request whose blob is complete. @param asked_at  the `now` that was passed to sent()
  /// with the request.
  using Tell = std::function<void(const core::Request& request, double asked_at)>;
  explicit OverheardRequests(Tell tell) : tell_(std::move(tell)) {}

  /// Notes the requests in complete frames that the client sends. @param now  time of any clock.
  void sent(std::span<const std::byte> frames, double now);
  /// Notes bytes that the client has received, which may end inside a frame. Forgets requests that end
  /// without their blob. Like core::Session, also forgets cancelled requests of which more than
  /// core::kMaxCancelledBytes have arrived.
  void received(std::span<const std::byte> bytes);

 private:
  struct Request {
    proto::RequestChange asked;
    double asked_at = 0;
    std::vector<std::byte> bytes;
    bool is_cancelled = false;
  };
  void note(const proto::RequestChange& change, double now);
  void takeChunk(const proto::BlobChunk& chunk);
  void forget(uint32_t number);
  void limitCancelledBytes(uint32_t number);

  Tell tell_;
  std::map<uint32_t, Request> requests_;  // by request number
  uint64_t cancelled_bytes_ = 0;          // number of bytes kept for cancelled requests
  std::vector<std::byte> input_;
};

}  // namespace lode::app
