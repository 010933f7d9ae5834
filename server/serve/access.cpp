#include "server/serve/access.h"

#include <string>

#include "common/error.h"
#include "server/serve/net/listener.h"

namespace lode::serve {

void checkAccessBeyondLoopback(const ServeOptions& options, const asio::ip::tcp::endpoint& endpoint) {
  if (endpoint.address().is_loopback()) return;
  const auto refuse = [&](const std::string& remedy) {
    throw Error(ErrorCode::kUsage, "other machines can connect to " + toString(endpoint) + ": " + remedy +
                                       ", or listen on 127.0.0.1");
  };
  if (options.token_file.empty() && !options.public_ok)
    refuse("give --token-file, or --public to let everybody read every model");
  if (options.tls_certificate.empty() && !options.insecure)
    refuse("give --tls-cert and --tls-key, or --insecure to send everything unencrypted");
}

void checkMetricsBeyondLoopback(const ServeOptions& options, const asio::ip::tcp::endpoint& endpoint) {
  if (options.public_ok || endpoint.address().is_loopback()) return;
  throw Error(ErrorCode::kUsage, "other machines can read the metrics at " + toString(endpoint) +
                                     ": give --public, or an address of loopback with --metrics");
}

}  // namespace lode::serve
