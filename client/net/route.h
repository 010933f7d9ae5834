#pragma once

#include <chrono>
#include <filesystem>
#include <memory>

#include "client/core/session/remedies.h"
#include "client/net/address.h"

namespace asio::ssl {
class context;
}

namespace lode::net {

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
