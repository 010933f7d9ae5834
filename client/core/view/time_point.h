#pragma once

#include <chrono>

namespace lode::core {

/// Time of the clock that the caller of the core reads.
using TimePoint = std::chrono::steady_clock::time_point;

}  // namespace lode::core
