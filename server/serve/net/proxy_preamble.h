#pragma once

#include <optional>

#include <asio/awaitable.hpp>
#include <asio/ip/tcp.hpp>

#include "server/serve/net/proxy_header.h"

namespace lode::serve {

/// Reads the balancer's header and not a byte more: the client's own may be TLS.
/// @return nothing if the peer closed before the first byte, as a check of health may.
/// @throws Error kNetwork: it is none, or the connection ended in it. A balancer that does not speak the
/// protocol is told nothing.
asio::awaitable<std::optional<ProxyHeader>> readProxyHeader(asio::ip::tcp::socket& socket);

}  // namespace lode::serve
