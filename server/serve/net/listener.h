#pragma once

#include <string>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>

namespace lode::serve {

/// The first address that ADDR:PORT or NAME:PORT stands for. @throws Error kUsage.
asio::ip::tcp::endpoint resolveListen(asio::io_context& context, const std::string& listen);

/// An acceptor that listens there. @param option  that named it: "--listen", for the error.
/// @throws Error kIo: a port in use and the like.
asio::ip::tcp::acceptor openListener(asio::io_context& context, const asio::ip::tcp::endpoint& endpoint,
                                     const std::string& option);

/// A socket that listens already, as a service manager hands it over. @throws Error kUsage: it is none of
/// TCP.
asio::ip::tcp::acceptor adoptListener(asio::io_context& context, int descriptor);

/// "127.0.0.1:7400", "[::1]:7400".
std::string toString(const asio::ip::tcp::endpoint& endpoint);

}  // namespace lode::serve
