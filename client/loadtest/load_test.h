#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "client/loadtest/load_client.h"
#include "client/loadtest/load_counts.h"

namespace lode::app {

struct LoadOptions {
  uint32_t clients = 1;
  unsigned threads = 1;  ///< number of threads that step the clients
  double seconds = 10;
  double ramp_s = 2.5;  ///< time over which the starts of the clients are spread evenly
  bool full = false;    ///< true runs full clients, false trace clients
  /// Called once a second with the counters of all clients, on the thread of runLoadTest(). May be empty.
  std::function<void(double seconds, const LoadCounts&)> progress;
  /// Called by every thread several times a second. If it returns true, the test ends early. May be empty.
  std::function<bool()> is_stopped;
};

struct LoadResult {
  LoadCounts counts;
  double seconds = 0;  ///< duration of the test
  bool interrupted = false;
};

/// Runs a load test. Client number i uses plan number i modulo the number of plans. Each client starts at its
/// own position of the trace or follows its own path.
/// @param plans  at least one plan. The test sets `end` of each plan.
/// @throws Error kUsage if the system does not allow that many connections.
LoadResult runLoadTest(std::span<LoadPlan> plans, const LoadOptions& options);

}  // namespace lode::app
