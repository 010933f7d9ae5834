#include "server/serve/tls.h"

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

}  // namespace lode::serve
