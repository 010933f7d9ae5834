#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <asio/awaitable.hpp>
#include <asio/ip/address.hpp>
#include <asio/ip/tcp.hpp>

namespace lode::serve {

/// Largest length of a header. Addresses take up to 232 bytes, and proxies add extensions about TLS.
constexpr size_t kMaxProxyHeaderBytes = 2048;

/// Header of HAProxy's PROXY protocol, version 1 (a line of text) or 2 (binary). A balancer sends it before
/// the client's own bytes.
struct ProxyHeader {
  size_t bytes = 0;  ///< length of the header
  /// The client's address; empty for the balancer's own connections, such as health checks.
  std::optional<asio::ip::address> client;
};

/// Parses the header at the start of a connection. Thread safe.
/// @param bytes  all bytes received so far.
/// @return the header, or nothing while the header is incomplete. A header has at most kMaxProxyHeaderBytes.
/// @throws Error kProtocol or kLimit as soon as the bytes cannot be a header.
std::optional<ProxyHeader> parseProxyHeader(std::span<const std::byte> bytes);

/// Reads the balancer's header. Leaves the client's own bytes in the socket, for example a TLS handshake.
/// @return nothing if the peer closed the connection before the first byte, as health checks do.
/// @throws Error kNetwork if the header is malformed or the connection ends within it. A peer that sends no
/// valid header gets no answer.
asio::awaitable<std::optional<ProxyHeader>> readProxyHeader(asio::ip::tcp::socket& socket);

}  // namespace lode::serve
