#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include <asio/ssl/context.hpp>

namespace lode::serve {

/// A server's side of TLS 1.3 with a certificate chain and its key, in PEM. Sessions that are not sending or
/// receiving keep no buffers.
/// @throws Error kUsage: a file that cannot be read, a key that is not the certificate's.
std::shared_ptr<asio::ssl::context> openTls(const std::filesystem::path& certificate,
                                            const std::filesystem::path& key);

/// When its own certificate expires; none if it has none.
std::optional<std::chrono::sys_seconds> expiryOf(asio::ssl::context& context);

}  // namespace lode::serve
