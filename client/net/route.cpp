#include "client/net/route.h"

#include <asio/ssl/context.hpp>
#include <openssl/ssl.h>

#include "common/error.h"

namespace lode::net {

std::shared_ptr<asio::ssl::context> trustAuthorities(const std::filesystem::path& ca_file,
                                                     const core::Remedies& remedies) {
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
                    error.message() + "; " + remedies.authorities);
  return context;
}

}  // namespace lode::net
