#pragma once

#include <span>

#include <nlohmann/json.hpp>

#include "client/app/cli/load_plan.h"
#include "client/app/cli/load_tally.h"
#include "client/app/cli/load_test.h"

namespace lode::app {

/// docs/json.md tells what the keys mean.
nlohmann::ordered_json toJson(const LoadOptions& options, std::span<const LoadPlan> plans,
                              const LoadTally& tally, double cpu_seconds);

/// One line on stdout.
void print(const LoadOptions& options, const LoadTally& tally);

/// A line a second on stderr, for who watches.
class LiveLine {
 public:
  /// @param now  what all have seen so far: the line tells what came since the last one.
  void print(double seconds, const LoadTally& now);

 private:
  LoadTally last_;
};

}  // namespace lode::app
