#include "client/net/address.h"

#include <charconv>

#include <asio/ssl/context.hpp>
#include <openssl/ssl.h>

#include "proto/limits.h"

namespace lode::net {
namespace {

constexpr size_t kMaxHostBytes = 253;  // RFC 1035

[[noreturn]] void refuse(std::string_view text, const char* why) {
  throw Error(ErrorCode::kUsage, "'" + std::string(text.substr(0, kMaxHostBytes)) + "' is not an address: " +
                                     why + "; write HOST or HOST:PORT, or [V6]:PORT");
}

uint16_t parsePort(std::string_view port, std::string_view text) {
  uint16_t value = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), value);
  if (error != std::errc() || end != port.data() + port.size() || value == 0)
    refuse(text, "the port must be a number from 1 to 65535");
  return value;
}

bool isHostCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' ||
         c == '_';
}

}  // namespace

Address parseAddress(std::string_view text) {
  Address address{{}, proto::kDefaultPort};
  std::string_view host = text;
  if (text.starts_with('[')) {
    const size_t close = text.find(']');
    if (close == std::string_view::npos) refuse(text, "the bracket is not closed");
    host = text.substr(1, close - 1);
    if (host.find_first_not_of("0123456789abcdefABCDEF:.%") != std::string_view::npos)
      refuse(text, "brackets may contain only an IPv6 address");
    const std::string_view rest = text.substr(close + 1);
    if (!rest.empty() && rest[0] != ':') refuse(text, "only a colon and a port may follow the bracket");
    if (!rest.empty()) address.port = parsePort(rest.substr(1), text);
  } else {
    const size_t colon = text.find(':');
    host = text.substr(0, colon);
    for (const char c : host)
      if (!isHostCharacter(c)) refuse(text, "the host name has an invalid character");
    if (colon != std::string_view::npos) address.port = parsePort(text.substr(colon + 1), text);
  }
  if (host.empty() || host.size() > kMaxHostBytes) refuse(text, "the host's name is missing or too long");
  address.host = host;
  return address;
}

std::string toString(const Address& address) {
  const bool v6 = address.host.find(':') != std::string::npos;
  return (v6 ? "[" + address.host + "]" : address.host) + ":" + std::to_string(address.port);
}

Error naming(const Address& server, const Error& error) {
  const std::string where = toString(server), what = error.what();
  return {error.code(), what.find(where) == std::string::npos ? where + ": " + what : what, error.remedy()};
}

std::shared_ptr<asio::ssl::context> trustAuthorities(const std::filesystem::path& ca_file) {
  const auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls_client);
  SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_3_VERSION);
  SSL_CTX_set_mode(context->native_handle(), SSL_MODE_RELEASE_BUFFERS);
  context->set_verify_mode(asio::ssl::verify_peer);
  asio::error_code error;
  if (ca_file.empty())
    context->set_default_verify_paths(error);
  else
    context->load_verify_file(ca_file.string(), error);
  if (error)
    throw Error(ErrorCode::kUsage,
                "cannot use the authorities in " +
                    (ca_file.empty() ? std::string("the system's folder") : ca_file.string()) + ": " +
                    error.message(),
                Remedy::kAuthorities);
  return context;
}

}  // namespace lode::net
