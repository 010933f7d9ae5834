#include "server/serve/access.h"

#include <string>

#include "common/error.h"
#include "server/serve/net/listener.h"

namespace lode::serve {

void checkAccessBeyondLoopback(const ServeOptions& options, const asio::ip::tcp::endpoint& endpoint) {
  if (endpoint.address().is_loopback()) return;
  const auto refuse = [&](const std::string& remedy) {
    throw Error(ErrorCode::kUsage, "refusing to listen on " + toString(endpoint) +
                                       ", which other machines can reach: " + remedy +
                                       ", or listen on 127.0.0.1");
  };
  if (options.token_file.empty() && !options.public_ok)
    refuse("give --token-file, or --public to let everybody read every model");
  if (options.tls_certificate.empty() && !options.insecure)
    refuse("give --tls-cert and --tls-key, or --insecure to send everything unencrypted");
}

void checkMetricsBeyondLoopback(const ServeOptions& options, const asio::ip::tcp::endpoint& endpoint) {
  if (options.public_ok || endpoint.address().is_loopback()) return;
  throw Error(ErrorCode::kUsage, "refusing to serve metrics at " + toString(endpoint) +
                                     ", where other machines can read them: give --public, or a loopback "
                                     "address with --metrics");
}

}  // namespace lode::serve
