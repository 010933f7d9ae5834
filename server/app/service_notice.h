#pragma once

#include <string>

namespace lode::app {

/// Tells systemd how a service fares ("READY=1" and so on, sd_notify(3)), where it runs one of type notify.
/// Elsewhere, and where it cannot be told, nothing happens.
void notifyService(const std::string& state) noexcept;

/// For MONOTONIC_USEC, which goes with RELOADING.
std::string monotonicMicroseconds();

}  // namespace lode::app
