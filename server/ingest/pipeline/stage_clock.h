#pragma once

#include <chrono>
#include <string>
#include <utility>

#include "server/ingest/plan/build_options.h"
#include "server/ingest/plan/machine.h"

namespace lode::ingest {

/// Measures the wall time and CPU time of a stage, from construction to finish().
class StageClock {
 public:
  StageClock(BuildReport& report, std::string name) : report_(report), name_(std::move(name)) {}

  void finish(uint64_t items, uint64_t temporary_bytes) {
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - wall_start_;
    report_.stages.push_back(
        {name_, wall.count(), cpuSeconds() - cpu_start_, items, temporary_bytes, peakRssBytes()});
    report_.seconds += report_.stages.back().seconds;
    report_.cpu_seconds += report_.stages.back().cpu_seconds;
    report_.peak_rss_bytes = peakRssBytes();
  }

 private:
  BuildReport& report_;
  const std::string name_;
  const std::chrono::steady_clock::time_point wall_start_ = std::chrono::steady_clock::now();
  const double cpu_start_ = cpuSeconds();
};

}  // namespace lode::ingest
