#pragma once

#include <filesystem>
#include <memory>

#include <asio/ssl/context.hpp>

namespace lode::serve {

/// A server's side of TLS 1.3 with a certificate chain and its key, in PEM. Sessions that are not sending or
/// receiving keep no buffers.
/// @throws Error kUsage: a file that cannot be read, a key that is not the certificate's.
std::shared_ptr<asio::ssl::context> openTls(const std::filesystem::path& certificate,
                                            const std::filesystem::path& key);

}  // namespace lode::serve
