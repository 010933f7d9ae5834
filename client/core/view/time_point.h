#pragma once

#include <chrono>

namespace lode::core {

/// Of a clock that the core's caller reads.
using TimePoint = std::chrono::steady_clock::time_point;

}  // namespace lode::core
