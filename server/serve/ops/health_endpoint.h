#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <asio/io_context.hpp>

namespace lode::serve {

constexpr size_t kMaxHealthRequestBytes = 8192;

/// First line of an HTTP request from Prometheus, a balancer or curl. The other lines are ignored.
struct HealthRequest {
  std::string path;        ///< path without the query after '?'
  bool head_only = false;  ///< true if the method is HEAD, so that the response has no body
  bool known_method = true;
};

/// Parses a request. @param text  bytes received so far. @return nothing until the request's head is
/// complete.
/// @throws Error kProtocol (not HTTP), kLimit (head too long). Thread safe.
std::optional<HealthRequest> parseHealthRequest(std::string_view text);

/// Returns a complete HTTP response that closes the connection. @param status  200, 404, 405 or 503.
std::string healthAnswer(int status, std::string_view content_type, std::string_view body, bool head_only);

/// Functions that produce the responses. All functions run on the context's thread and must be quick.
struct HealthAnswers {
  std::function<std::string()> metrics;  ///< Prometheus' text format
  std::function<bool()> ready;           ///< true while a balancer should send clients to this server
};

/// A minimal HTTP server on a second port. The endpoint answers GET /metrics with the metrics, /healthz with
/// 200 while the context runs, and /readyz with 200 while the server is ready, else with 503. The endpoint
/// serves a few connections at a time, each with a short deadline.
class HealthEndpoint {
 public:
  /// Starts to listen. The endpoint answers while the context runs.
  /// @param listen  ADDR:PORT; port 0 selects a free port.
  /// @throws Error kUsage, kIo.
  HealthEndpoint(asio::io_context& context, const std::string& listen, HealthAnswers answers);
  ~HealthEndpoint();  ///< call the destructor on the context's thread, or after the context has stopped
  HealthEndpoint(const HealthEndpoint&) = delete;
  HealthEndpoint& operator=(const HealthEndpoint&) = delete;

  std::string address() const;  ///< address of the port, such as "127.0.0.1:9400"

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace lode::serve
