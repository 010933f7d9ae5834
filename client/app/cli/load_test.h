#pragma once

#include <cstdint>

#include "client/app/cli/load_client.h"

namespace lode::app {

struct LoadOptions {
  uint32_t clients = 1;
  unsigned threads = 1;  ///< that step them
  double seconds = 10;
};

/// Lets clients replay a trace against a server for a time, on a few threads. They start one after the other
/// within a quarter of it, each at another place of the trace.
/// @param plan  but for its end. @throws Error kUsage if the system does not allow so many connections.
LoadTally runLoadTest(LoadPlan plan, const LoadOptions& options);

}  // namespace lode::app
