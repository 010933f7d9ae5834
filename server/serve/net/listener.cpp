#include "server/serve/net/listener.h"

#include <cerrno>

#include <sys/socket.h>

#include "common/error.h"
#include "server/serve/net/listen_address.h"

namespace lode::serve {

using asio::ip::tcp;

tcp::endpoint resolveListen(asio::io_context& context, const std::string& listen) {
  const ListenAddress wanted = parseListenAddress(listen);
  asio::error_code error;
  const auto found =
      tcp::resolver(context).resolve(wanted.host, std::to_string(wanted.port), tcp::resolver::passive, error);
  if (error || found.empty())
    throw Error(ErrorCode::kUsage,
                "cannot listen on " + listen + ": " + error.message() + "; name an address of this machine");
  return found.begin()->endpoint();
}

namespace {

std::string remedyFor(const asio::error_code& error, const std::string& option) {
  if (error.value() == EADDRNOTAVAIL) return "name an address of this machine with " + option;
  if (error == asio::error::access_denied) return "choose a port from 1024 on with " + option;
  return "stop what uses it or choose another with " + option + " (port 0 picks a free one)";
}

}  // namespace

tcp::acceptor openListener(asio::io_context& context, const tcp::endpoint& endpoint,
                           const std::string& option) {
  tcp::acceptor acceptor(context);
  asio::error_code error;
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(tcp::acceptor::max_listen_connections, error);
  if (error)
    throw Error(ErrorCode::kIo, "cannot listen on " + toString(endpoint) + ": " + error.message() + "; " +
                                    remedyFor(error, option));
  return acceptor;
}

tcp::acceptor adoptListener(asio::io_context& context, int descriptor) {
  sockaddr_storage address{};
  socklen_t length = sizeof address;
  int listens = 0, type = 0;
  socklen_t option_length = sizeof listens;
  const bool is_socket = getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &length) == 0 &&
                         getsockopt(descriptor, SOL_SOCKET, SO_ACCEPTCONN, &listens, &option_length) == 0 &&
                         getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &type, &option_length) == 0;
  const bool is_tcp = type == SOCK_STREAM && (address.ss_family == AF_INET || address.ss_family == AF_INET6);
  if (!is_socket || listens == 0 || !is_tcp)
    throw Error(ErrorCode::kUsage,
                "the service manager's socket does not listen on TCP; give it ListenStream=PORT");
  tcp::acceptor acceptor(context);
  acceptor.assign(address.ss_family == AF_INET ? tcp::v4() : tcp::v6(), descriptor);
  return acceptor;
}

std::string toString(const tcp::endpoint& endpoint) {
  const std::string host = endpoint.address().to_string();
  return (endpoint.address().is_v6() ? "[" + host + "]" : host) + ":" + std::to_string(endpoint.port());
}

}  // namespace lode::serve
