#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <asio/ip/address.hpp>

namespace lode::serve {

/// A whole header is at most this long: the addresses take 232 bytes, the rest is what proxies add about TLS.
constexpr size_t kMaxProxyHeaderBytes = 2048;

/// What a balancer says of a connection before the client's own bytes: HAProxy's PROXY protocol, version 1
/// (a line of text) or 2 (binary).
struct ProxyHeader {
  size_t bytes = 0;                         ///< of the header; the client's own bytes follow
  std::optional<asio::ip::address> client;  ///< none where the balancer speaks for itself, as to check health
};

/// @param bytes  what has come so far, from the connection's first byte on.
/// @return nothing while the header is not complete; that is at most kMaxProxyHeaderBytes.
/// @throws Error kProtocol, kLimit as soon as it cannot be a header any more. Thread safe.
std::optional<ProxyHeader> parseProxyHeader(std::span<const std::byte> bytes);

}  // namespace lode::serve
