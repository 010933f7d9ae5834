#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "common/error.h"

namespace asio::ssl {
class context;
}

namespace lode::net {

struct Address {
  std::string host;  ///< host name or IP address, without brackets
  uint16_t port = 0;
  bool operator==(const Address&) const = default;
};

/// Parses "host", "host:port" or "[v6]:port". @throws Error kUsage.
Address parseAddress(std::string_view text);
/// Returns "host:port", with brackets around an IPv6 address.
std::string toString(const Address& address);
/// Returns the error with the server's address in front of the message, unless the message already contains
/// the address.
Error naming(const Address& server, const Error& error);

/// Address and connection settings of a server.
struct Route {
  Address address;
  std::chrono::milliseconds connect_timeout{20'000};  ///< until the server's first byte
  std::shared_ptr<asio::ssl::context> tls = nullptr;  ///< TLS context; null selects plain TCP
};

/// Creates a TLS 1.3 client context that verifies server certificates.
/// @param ca_file  trusted certificate authorities, in PEM; empty: the system's authorities.
/// @throws Error kUsage, with Remedy::kAuthorities, if the file cannot be read or contains no certificate.
std::shared_ptr<asio::ssl::context> trustAuthorities(const std::filesystem::path& ca_file);

}  // namespace lode::net
