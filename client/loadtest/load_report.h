#pragma once

#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "client/loadtest/load_counts.h"
#include "client/loadtest/load_plan.h"
#include "client/loadtest/load_test.h"

namespace lode::app {

/// docs/json.md tells what the keys mean.
nlohmann::ordered_json toJson(const LoadOptions& options, std::span<const LoadPlan> plans,
                              const LoadResult& result, double cpu_seconds);

/// The result in one line.
std::string describe(const LoadOptions& options, const LoadResult& result);

/// A line a second on stderr, for who watches.
class LiveLine {
 public:
  /// @param now  what all have seen so far: the line tells what came since the last one.
  void print(double seconds, const LoadCounts& now);

 private:
  LoadCounts last_;
};

}  // namespace lode::app
