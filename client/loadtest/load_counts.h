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
  /// Latency of requests by request class. It begins when a full client sends the request, or when a trace
  /// client intends to send it, and ends with the last byte of the blob.
  std::array<LatencyHistogram, 3> latency;
  /// Time from a client's intended start to the arrival of the root's coarsest LOD.
  LatencyHistogram first_image;
  LatencyHistogram converged;  ///< time until the first converged picture; full clients only
  double looked_s = 0;         ///< time since their start, summed over all full clients
  double far_off_s = 0;        ///< part of looked_s with a far too coarse picture: see core::isFarOff()
  uint64_t started = 0;        ///< clients that have started
  uint64_t blobs = 0, bytes = 0, unanswered = 0;
  /// Connections that clients replaced because the server announced its shutdown (GoAway).
  uint64_t moved = 0;
  uint64_t turned_away = 0;  ///< connections that a full or stopping server refused; the clients retried
  uint64_t lost = 0;         ///< broken or failed connections; each also counts as an error
  /// Requests that were refused, or open when a connection broke. Clients repeat the latter.
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
