#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>

#include "client/core/view/time_point.h"
#include "proto/messages.h"

namespace lode::app {

/// How long the requests of one connection take, by the frames that its client sends. Not thread safe.
class RequestClock {
 public:
  struct Request {
    uint32_t number;
    proto::RequestClass request_class;
    core::TimePoint sent;
  };

  /// By blob.
  using Requests = std::map<uint32_t, Request>;

  /// Whole frames. @param lost  of connections that broke off: those made again here leave it, and count from
  /// when they were sent first.
  void sent(std::span<const std::byte> frames, core::TimePoint now, Requests& lost);
  /// @return the request a blob that has come; none if it came unasked.
  std::optional<Request> arrived(uint32_t blob);
  /// The blob will not come.
  void refused(uint32_t blob) { arrived(blob); }
  /// Those that have not come.
  const Requests& open() const noexcept { return open_; }

 private:
  Requests open_;
  std::map<uint32_t, uint32_t> blob_of_;  ///< by request
};

}  // namespace lode::app
