#pragma once

#include <chrono>

namespace lode::core {

/// Time that the caller passes in; the core reads no clock itself.
using TimePoint = std::chrono::steady_clock::time_point;

}  // namespace lode::core
