#pragma once

#include <optional>
#include <string>

namespace lode::app {

/// The socket that systemd listens on for us (socket activation, sd_listen_fds(3)), or none.
/// @throws Error kUsage: there are several.
std::optional<int> socketOfService();

/// Tells systemd how a service fares ("READY=1" and so on, sd_notify(3)), where it runs one of type notify.
/// Elsewhere, and where it cannot be told, nothing happens.
void notifyService(const std::string& state) noexcept;

/// For MONOTONIC_USEC, which goes with RELOADING.
std::string monotonicMicroseconds();

}  // namespace lode::app
