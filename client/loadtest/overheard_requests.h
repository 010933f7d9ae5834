#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "client/core/session/session.h"
#include "proto/frame.h"
#include "proto/messages.h"

namespace lode::app {

/// Overhears the conversation of a client with its server, both ways, and tells of each request once its blob
/// is there. Of a client of one's own: what cannot be throws. Not thread safe.
class OverheardRequests {
 public:
  /// @param asked_at  what sent() was told with the request.
  using Tell = std::function<void(const core::Request& request, double asked_at)>;
  explicit OverheardRequests(Tell tell) : tell_(std::move(tell)) {}

  /// Whole frames that the client sends. @param now  any clock.
  void sent(std::span<const std::byte> frames, double now);
  /// Bytes that came for it, cut anywhere.
  void received(std::span<const std::byte> bytes);

 private:
  struct Request {
    proto::RequestChange asked;
    double asked_at = 0;
    std::vector<std::byte> bytes;
  };
  void takeChunk(const proto::BlobChunk& chunk);

  Tell tell_;
  std::map<uint32_t, Request> requests_;
  std::vector<std::byte> input_;
};

}  // namespace lode::app
