#pragma once

#include <cstdio>

#include <nlohmann/json.hpp>

namespace lode::bench {

/// Prints a measurement as one JSON object on a line, for tests/bench/compare.py: strings name the row,
/// numbers are results.
inline void printRow(const nlohmann::ordered_json& row) {
  std::puts(row.dump().c_str());
  std::fflush(stdout);
}

}  // namespace lode::bench
