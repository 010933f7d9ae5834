#pragma once

#include <optional>
#include <string>

namespace lode::app {

/// Returns the listening socket that systemd passed (socket activation, sd_listen_fds(3)), or nothing.
/// @throws Error kUsage if systemd passed several.
std::optional<int> socketOfService();

/// Notifies systemd of the service's state, such as "READY=1" (sd_notify(3)), in services of type notify.
/// Does nothing elsewhere and ignores errors.
void notifyService(const std::string& state) noexcept;

/// Returns the value of MONOTONIC_USEC, which RELOADING=1 requires.
std::string monotonicMicroseconds();

}  // namespace lode::app
