#pragma once

#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "client/loadtest/load_client.h"
#include "client/loadtest/load_counts.h"
#include "client/loadtest/load_test.h"

namespace lode::app {

/// Returns the result as --json prints it. docs/json.md describes the keys.
nlohmann::ordered_json toJson(const LoadOptions& options, std::span<const LoadPlan> plans,
                              const LoadResult& result, double cpu_seconds);

/// Describes the result in one line.
std::string describe(const LoadOptions& options, const LoadResult& result);

/// Prints the progress on stderr, one line per call.
class LiveLine {
 public:
  /// Prints a line: rates and latencies since the last line, and totals. @param now  counters of all clients.
  void print(double seconds, const LoadCounts& now);

 private:
  LoadCounts last_;
};

}  // namespace lode::app
