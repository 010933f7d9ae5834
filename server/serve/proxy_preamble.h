#pragma once

#include <asio/awaitable.hpp>
#include <asio/ip/tcp.hpp>

#include "server/serve/proxy_header.h"

namespace lode::serve {

/// Reads the balancer's header and not a byte more: the client's own may be TLS.
/// @throws Error kNetwork: it is none, or the connection ended in it. A balancer that does not speak the
/// protocol is told nothing.
asio::awaitable<ProxyHeader> readProxyHeader(asio::ip::tcp::socket& socket);

}  // namespace lode::serve
