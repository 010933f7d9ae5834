#include "server/serve/net/listener.h"

#include <cerrno>
#include <charconv>
#include <ctime>
#include <string>

#include <openssl/ssl.h>
#include <sys/socket.h>

#include "common/error.h"
#include "proto/limits.h"

namespace lode::serve {

using asio::ip::tcp;

namespace {

std::string remedyFor(const asio::error_code& error, const std::string& option) {
  if (error.value() == EADDRNOTAVAIL) return "name an address of this machine with " + option;
  if (error == asio::error::access_denied) return "choose a port from 1024 on with " + option;
  return "stop the program that uses it or choose another port with " + option + " (port 0 picks a free one)";
}

}  // namespace

ListenAddress parseListenAddress(std::string_view text) {
  const auto wrong = [&] {
    return Error(ErrorCode::kUsage,
                 "'" + std::string(text) +
                     "' is not an address to listen on; write it as 127.0.0.1:7400 or [::1]:7400");
  };
  std::string_view host = text, port;
  if (text.starts_with('[')) {
    const size_t end = text.find(']');
    if (end == std::string_view::npos) throw wrong();
    host = text.substr(1, end - 1);
    port = text.substr(end + 1);
    if (!port.empty() && !port.starts_with(':')) throw wrong();
  } else if (const size_t colon = text.find(':'); colon != std::string_view::npos) {
    host = text.substr(0, colon);
    port = text.substr(colon);
  }
  // Refuse a host that is a plain number: the user means a port, but the resolver would read the number as an
  // IPv4 address.
  if (host.find_first_not_of("0123456789") == std::string_view::npos) throw wrong();
  ListenAddress address{std::string(host), proto::kDefaultPort};
  if (port.empty()) return address;
  const char* const end = port.data() + port.size();
  const auto [stop, error] = std::from_chars(port.data() + 1, end, address.port);
  if (error != std::errc() || stop != end) throw wrong();
  return address;
}

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

std::shared_ptr<asio::ssl::context> openTls(const std::filesystem::path& certificate,
                                            const std::filesystem::path& key) {
  const auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls_server);
  SSL_CTX* const native = context->native_handle();
  SSL_CTX_set_min_proto_version(native, TLS1_3_VERSION);
  SSL_CTX_set_mode(native, SSL_MODE_RELEASE_BUFFERS);
  SSL_CTX_set_session_cache_mode(native, SSL_SESS_CACHE_OFF);
  asio::error_code error;
  context->use_certificate_chain_file(certificate.string(), error);
  if (error)
    throw Error(ErrorCode::kUsage, "cannot use the certificate " + certificate.string() + ": " +
                                       error.message() + "; give a chain in PEM, the server's own first");
  context->use_private_key_file(key.string(), asio::ssl::context::pem, error);
  if (error)
    throw Error(ErrorCode::kUsage, "cannot use the key " + key.string() + ": " + error.message() +
                                       "; give the certificate's own key in PEM, without a password");
  return context;
}

std::optional<std::chrono::sys_seconds> expiryOf(asio::ssl::context& context) {
  const X509* const certificate = SSL_CTX_get0_certificate(context.native_handle());
  std::tm time{};
  if (certificate == nullptr || ASN1_TIME_to_tm(X509_get0_notAfter(certificate), &time) != 1) return {};
  return std::chrono::sys_seconds(std::chrono::seconds(::timegm(&time)));
}

}  // namespace lode::serve
