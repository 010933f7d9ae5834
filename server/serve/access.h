#pragma once

#include <asio/ip/tcp.hpp>

#include "server/serve/server.h"

namespace lode::serve {

/// Requires tokens and TLS, or the options that waive them, for an address beyond loopback.
/// @throws Error kUsage.
void checkAccessBeyondLoopback(const ServeOptions& options, const asio::ip::tcp::endpoint& endpoint);

/// Requires --public for metrics beyond loopback, because everybody who reaches the metrics can read the
/// names of all models.
/// @throws Error kUsage.
void checkMetricsBeyondLoopback(const ServeOptions& options, const asio::ip::tcp::endpoint& endpoint);

}  // namespace lode::serve
