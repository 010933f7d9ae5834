#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <asio/io_context.hpp>

namespace lode::serve {

/// What the endpoint says; called on its context's thread, and quick.
struct HealthAnswers {
  std::function<std::string()> metrics;  ///< Prometheus' text
  std::function<bool()> ready;           ///< whether a balancer should send clients here
};

/// A second port that speaks just enough HTTP: GET /metrics; /healthz, which is there as long as the
/// context's loop turns; /readyz, 503 where the server is not ready. A few connections at a time, a short
/// deadline each.
class HealthEndpoint {
 public:
  /// Listens; answers while the context runs. @param listen  ADDR:PORT, port 0 picks one.
  /// @throws Error kUsage, kIo.
  HealthEndpoint(asio::io_context& context, const std::string& listen, HealthAnswers answers);
  ~HealthEndpoint();  ///< on the context's thread, or after it has stopped
  HealthEndpoint(const HealthEndpoint&) = delete;
  HealthEndpoint& operator=(const HealthEndpoint&) = delete;

  std::string address() const;  ///< "127.0.0.1:9400"

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace lode::serve
