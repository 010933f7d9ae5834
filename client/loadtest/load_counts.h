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
  /// Latency of requests by request class. For trace clients, the time from the intended time to the last
  /// byte; for full clients, from sending to the last byte.
  std::array<LatencyHistogram, 3> latency;
  LatencyHistogram first_image;  ///< time from a client's intended start to the root's coarsest LOD
  LatencyHistogram converged;    ///< full clients: time until the first converged picture
  double looked_s = 0;           ///< full clients: time since their start
  double far_off_s = 0;  ///< full clients: part of looked_s with a too large error, see core::isFarOff()
  uint64_t started = 0;  ///< clients that have started
  uint64_t blobs = 0, bytes = 0, unanswered = 0;
  uint64_t moved = 0;  ///< connections that clients replaced after the server announced its end (GoAway)
  uint64_t turned_away = 0;  ///< connections that a full or stopping server refused; the clients retried
  uint64_t lost = 0;         ///< broken or failed connections; each also counts as an error
  /// Refused requests, and open requests of broken connections, which the client repeats.
  uint64_t failed_requests = 0;
  uint64_t gave_up = 0;  ///< clients that ended with an error
  /// Number of errors by code: errors that ended a client or a connection, and refused blobs.
  std::map<ErrorCode, uint64_t> errors;
  std::string first_error;

  void add(const LoadCounts& other);
  void noteError(ErrorCode code, const std::string& what);
  uint64_t errorCount() const noexcept;
};

}  // namespace lode::app
