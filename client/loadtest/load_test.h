#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "client/loadtest/load_client.h"
#include "client/loadtest/load_counts.h"

namespace lode::app {

struct LoadOptions {
  uint32_t clients = 1;
  unsigned threads = 1;  ///< threads that step the clients
  double seconds = 10;
  double ramp_s = 2.5;  ///< clients start one after the other during this time
  bool full = false;    ///< full clients instead of trace clients
  /// Receives the counters of all clients once a second on the caller's thread; may be empty.
  std::function<void(double seconds, const LoadCounts&)> progress;
  /// Called by every thread several times a second; returning true ends the test. May be empty.
  std::function<bool()> is_stopped;
};

struct LoadResult {
  LoadCounts counts;
  double seconds = 0;  ///< duration of the test
  bool interrupted = false;
};

/// Runs a load test. Clients take the plans in turn; each starts at its own position of the trace or follows
/// its own path.
/// @param plans  at least one; sets their `end`. @throws Error kUsage if the system does not allow that many
/// connections.
LoadResult runLoadTest(std::span<LoadPlan> plans, const LoadOptions& options);

}  // namespace lode::app
