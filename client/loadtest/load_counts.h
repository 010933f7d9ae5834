#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "client/loadtest/latency_histogram.h"
#include "common/error.h"

namespace lode::app {

/// Counters of the clients of one thread.
struct LoadCounts {
  /// Latency of requests by request class. The latency ends with the last byte of the blob. The latency
  /// begins at the intended time for trace clients, and when the request is sent for full clients.
  std::array<LatencyHistogram, 3> latency;
  LatencyHistogram first_image;  ///< time from a client's intended start to the root's coarsest LOD
  LatencyHistogram converged;    ///< time until the first converged picture; full clients only
  double looked_s = 0;           ///< sum over full clients of the time since their start
  double far_off_s = 0;          ///< part of looked_s with a picture that is far off: see core::isFarOff()
  uint64_t started = 0;          ///< clients that have started
  uint64_t blobs = 0, bytes = 0, unanswered = 0;
  uint64_t moved = 0;  ///< connections that clients replaced because the server announced its end (GoAway)
  uint64_t turned_away = 0;  ///< connections that a full or stopping server refused; the clients retried
  uint64_t lost = 0;         ///< broken or failed connections; each also counts as an error
  /// Number of refused requests and of requests that were open when a connection broke. Clients repeat the
  /// requests of broken connections.
  uint64_t failed_requests = 0;
  uint64_t gave_up = 0;  ///< clients that ended with an error
  /// Number of errors by code: errors that ended a client or a connection, and refused blobs.
  std::map<ErrorCode, uint64_t> errors;
  std::string first_error;

  void add(const LoadCounts& other);
  void noteError(const Error& error);
  uint64_t errorCount() const noexcept;
};

}  // namespace lode::app
