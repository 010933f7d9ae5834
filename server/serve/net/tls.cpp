#include "server/serve/net/tls.h"

#include <ctime>
#include <string>

#include <openssl/ssl.h>

#include "common/error.h"

namespace lode::serve {

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
