#pragma once

#include <optional>
#include <string>

namespace lode::app {

/// Returns the listening socket that systemd passed (socket activation, sd_listen_fds(3)), or nothing.
/// @throws Error kUsage if systemd passed several sockets.
std::optional<int> socketOfService();

/// Notifies systemd of the service's state, such as "READY=1" (sd_notify(3)). Does nothing if the process is
/// not a service of type notify. Ignores errors.
void notifyService(const std::string& state) noexcept;

/// Returns the value of MONOTONIC_USEC, which a notice with RELOADING=1 must contain.
std::string monotonicMicroseconds();

}  // namespace lode::app
