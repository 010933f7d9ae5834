#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "client/loadtest/latency_histogram.h"
#include "common/error.h"

namespace lode::app {

/// What the clients of one thread have seen.
struct LoadCounts {
  /// By class, from a request's intended time to its last byte; of a full client from when it was sent.
  std::array<LatencyHistogram, 3> latency;
  LatencyHistogram first_image;  ///< from a client's intended start to the root's coarsest LOD
  LatencyHistogram converged;    ///< of full clients: until the first picture that needs nothing more
  double looked_s = 0;           ///< of full clients
  double far_off_s = 0;          ///< in which their pictures were off by more than twice the threshold
  uint64_t started = 0;          ///< clients
  uint64_t blobs = 0, bytes = 0, unanswered = 0;
  uint64_t moved = 0;  ///< clients that a server told to go away, and who went on with another connection
  uint64_t turned_away = 0;  ///< times that a server let a client not in, full or going away; it came again
  uint64_t lost = 0;  ///< connections that broke, or that could not be made anew; each is an error, too
  uint64_t failed_requests = 0;  ///< refused, or open when a connection broke; those were requested again
  uint64_t gave_up = 0;          ///< clients that an error has ended
  /// That ended a client or a connection, or came in the place of a blob.
  std::map<ErrorCode, uint64_t> errors;
  std::string first_error;

  void add(const LoadCounts& other);
  void noteError(ErrorCode code, const std::string& what);
  uint64_t errorCount() const noexcept;
};

}  // namespace lode::app
