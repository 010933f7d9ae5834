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
  /// By request class, until the last byte: from the intended time (trace clients) or from sending (full
  /// ones).
  std::array<LatencyHistogram, 3> latency;
  LatencyHistogram first_image;  ///< from a client's intended start to the root's coarsest LOD
  LatencyHistogram converged;    ///< full clients: time until the first converged picture
  double looked_s = 0;           ///< full clients: time with a picture
  double far_off_s = 0;          ///< time in which the error exceeded twice the threshold
  uint64_t started = 0;          ///< clients
  uint64_t blobs = 0, bytes = 0, unanswered = 0;
  uint64_t moved = 0;        ///< clients that changed the connection after GoAway
  uint64_t turned_away = 0;  ///< refused connections: the server was full or stopping; the client retried
  uint64_t lost = 0;         ///< broken or failed connections; each is also an error
  uint64_t failed_requests =
      0;                 ///< refused requests, and open ones of broken connections, which were repeated
  uint64_t gave_up = 0;  ///< clients that ended with an error
  /// Errors that ended a client or a connection, or replaced a blob.
  std::map<ErrorCode, uint64_t> errors;
  std::string first_error;

  void add(const LoadCounts& other);
  void noteError(ErrorCode code, const std::string& what);
  uint64_t errorCount() const noexcept;
};

}  // namespace lode::app
