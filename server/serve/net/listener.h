#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/ssl/context.hpp>

namespace lode::serve {

struct ListenAddress {
  std::string host;
  uint16_t port = 0;
};

/// Parses "127.0.0.1:7400", "[::1]:7400" or "localhost:0". The default port is kDefaultPort.
/// @throws Error kUsage.
ListenAddress parseListenAddress(std::string_view text);

/// Resolves ADDR:PORT or NAME:PORT to its first address. @throws Error kUsage.
asio::ip::tcp::endpoint resolveListen(asio::io_context& context, const std::string& listen);

/// Opens an acceptor that listens on the endpoint. @param option  option that error messages name, such as
/// "--listen".
/// @throws Error kIo, for example if the port is in use.
asio::ip::tcp::acceptor openListener(asio::io_context& context, const asio::ip::tcp::endpoint& endpoint,
                                     const std::string& option);

/// Adopts a listening socket from the service manager. @throws Error kUsage if it does not listen on TCP.
asio::ip::tcp::acceptor adoptListener(asio::io_context& context, int descriptor);

/// Formats an endpoint as "127.0.0.1:7400" or "[::1]:7400".
std::string toString(const asio::ip::tcp::endpoint& endpoint);

/// Creates the server's context for TLS 1.3 from PEM files with a certificate chain and its key. Idle TLS
/// sessions of this context free their buffers.
/// @throws Error kUsage if a file cannot be read or the key does not match the certificate.
std::shared_ptr<asio::ssl::context> openTls(const std::filesystem::path& certificate,
                                            const std::filesystem::path& key);

/// Returns the time at which the context's own certificate expires. Returns nothing if the context has no
/// certificate.
std::optional<std::chrono::sys_seconds> expiryOf(asio::ssl::context& context);

}  // namespace lode::serve
