#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "client/core/session/remedies.h"
#include "common/error.h"

namespace asio::ssl {
class context;
}

namespace lode::net {

struct Address {
  std::string host;  ///< name or number, without brackets
  uint16_t port = 0;
  bool operator==(const Address&) const = default;
};

/// "host:port", "host", "[v6]:port". @throws Error kUsage.
Address parseAddress(std::string_view text);
/// With brackets where needed.
std::string toString(const Address& address);
/// An error with the server that it is about before it, unless it names that already.
Error naming(const Address& server, const Error& error);

/// How a server is reached.
struct Route {
  Address address;
  std::chrono::milliseconds connect_timeout{20'000};  ///< up to the server's first word
  std::shared_ptr<asio::ssl::context> tls = nullptr;  ///< null: plain TCP
  core::Remedies remedies = {};
};

/// A client's side of TLS 1.3, which believes servers whose certificate an authority vouches for.
/// @param ca_file  certificates of authorities, in PEM; empty: those of the system.
/// @throws Error kUsage: a file that cannot be read or holds no certificate.
std::shared_ptr<asio::ssl::context> trustAuthorities(const std::filesystem::path& ca_file,
                                                     const core::Remedies& remedies = {});

}  // namespace lode::net
