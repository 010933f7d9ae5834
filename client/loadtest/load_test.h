#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "client/loadtest/load_counts.h"
#include "client/loadtest/load_plan.h"

namespace lode::app {

struct LoadOptions {
  uint32_t clients = 1;
  unsigned threads = 1;  ///< that step them
  double seconds = 10;
  double ramp_s = 2.5;  ///< in which they start, one after the other
  bool full = false;    ///< they refine and decode; else they replay the plans' traces
  /// Called once a second on the caller's thread with what all have seen so far; may be empty.
  std::function<void(double seconds, const LoadCounts&)> progress;
  /// Asked several times a second by every thread: the test ends early once it says so; may be empty.
  std::function<bool()> is_stopped;
};

struct LoadResult {
  LoadCounts counts;
  double seconds = 0;  ///< that it took
  bool interrupted = false;
};

/// Lets clients load servers for a time, on a few threads. They take the plans by turns, and each begins at
/// another place of its trace or goes along a path of its own.
/// @param plans  at least one; but for their end. @throws Error kUsage if the system does not allow so many
/// connections.
LoadResult runLoadTest(std::span<LoadPlan> plans, const LoadOptions& options);

}  // namespace lode::app
