#include "server/serve/ops/health_endpoint.h"

#include <array>
#include <chrono>
#include <deque>
#include <exception>
#include <string>
#include <utility>

#include <asio/awaitable.hpp>
#include <asio/buffer.hpp>
#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/redirect_error.hpp>
#include <asio/steady_timer.hpp>
#include <asio/use_awaitable.hpp>
#include <asio/write.hpp>

#include "common/error.h"
#include "server/serve/net/listener.h"

namespace lode::serve {

namespace {

std::string_view reasonOf(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    default:
      return "Service Unavailable";
  }
}

using asio::ip::tcp;

/// Largest number of clients at a time; a further client ends the oldest connection.
constexpr size_t kMaxClients = 16;
constexpr auto kAnswerWithin = std::chrono::seconds(5);  ///< time from accept() to the last byte sent
constexpr auto kPauseAfterRefusal = std::chrono::milliseconds(100);
constexpr const char* kMetricsType = "text/plain; version=0.0.4; charset=utf-8";
constexpr const char* kPlain = "text/plain; charset=utf-8";

}  // namespace

std::optional<HealthRequest> parseHealthRequest(std::string_view text) {
  if (text.find("\r\n\r\n") == std::string_view::npos) {
    if (text.size() >= kMaxHealthRequestBytes)
      throw Error(ErrorCode::kLimit,
                  "an HTTP request is longer than " + std::to_string(kMaxHealthRequestBytes) + " bytes");
    return {};
  }
  const std::string_view line = text.substr(0, text.find("\r\n"));
  const size_t first = line.find(' '), last = line.rfind(' ');
  if (first == std::string_view::npos || first == last || !line.substr(last + 1).starts_with("HTTP/1."))
    throw Error(ErrorCode::kProtocol, "a client of the metrics port does not speak HTTP");
  const std::string_view method = line.substr(0, first);
  const std::string_view target = line.substr(first + 1, last - first - 1);
  return HealthRequest{std::string(target.substr(0, target.find('?'))), method == "HEAD",
                       method == "GET" || method == "HEAD"};
}

std::string healthAnswer(int status, std::string_view content_type, std::string_view body, bool head_only) {
  std::string answer = "HTTP/1.1 " + std::to_string(status) + ' ' + std::string(reasonOf(status)) +
                       "\r\nContent-Type: " + std::string(content_type) +
                       "\r\nContent-Length: " + std::to_string(body.size()) +
                       "\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n";
  return head_only ? answer : answer += body;
}

struct HealthEndpoint::State : std::enable_shared_from_this<State> {
  State(asio::io_context& io, const std::string& listen, HealthAnswers wanted)
      : acceptor(openListener(io, resolveListen(io, listen), "--metrics")), answers(std::move(wanted)) {}

  asio::awaitable<void> accept();
  asio::awaitable<void> serve(std::shared_ptr<tcp::socket> socket);
  asio::awaitable<void> converse(tcp::socket& socket);
  std::string answer(const HealthRequest& request) const;

  tcp::acceptor acceptor;
  std::deque<std::shared_ptr<tcp::socket>> clients;  ///< open connections, oldest first
  HealthAnswers answers;
};

std::string HealthEndpoint::State::answer(const HealthRequest& request) const {
  const auto say = [&](int status, const char* type, const std::string& body) {
    return healthAnswer(status, type, body, request.head_only);
  };
  if (!request.known_method) return say(405, kPlain, "use GET\n");
  if (request.path == "/healthz") return say(200, kPlain, "alive\n");
  if (request.path == "/readyz")
    return answers.ready() ? say(200, kPlain, "ready\n") : say(503, kPlain, "stopping\n");
  if (request.path == "/metrics") return say(200, kMetricsType, answers.metrics());
  return say(404, kPlain, "try /metrics, /healthz or /readyz\n");
}

asio::awaitable<void> HealthEndpoint::State::converse(tcp::socket& socket) {
  std::string asked;
  std::optional<HealthRequest> request;
  while (!request) {
    std::array<char, 1024> part;
    const size_t count = co_await socket.async_read_some(asio::buffer(part), asio::use_awaitable);
    asked.append(part.data(), count);
    request = parseHealthRequest(asked);
  }
  const std::string said = answer(*request);
  co_await asio::async_write(socket, asio::buffer(said), asio::use_awaitable);
  socket.shutdown(tcp::socket::shutdown_send);
}

asio::awaitable<void> HealthEndpoint::State::serve(std::shared_ptr<tcp::socket> socket) {
  asio::steady_timer deadline(socket->get_executor(), kAnswerWithin);
  deadline.async_wait([socket](const asio::error_code& cancelled) {
    asio::error_code ignored;
    if (!cancelled) socket->close(ignored);
  });
  try {
    co_await converse(*socket);
  } catch (const std::exception&) {
    // Close the connection. The client is gone, too slow or does not speak HTTP, or memory ran out.
  }
  deadline.cancel();
  std::erase(clients, socket);
}

asio::awaitable<void> HealthEndpoint::State::accept() {
  const auto self = shared_from_this();
  while (acceptor.is_open()) {
    asio::error_code error;
    tcp::socket socket = co_await acceptor.async_accept(asio::redirect_error(asio::use_awaitable, error));
    if (error) {
      asio::steady_timer pause(acceptor.get_executor(), kPauseAfterRefusal);
      if (acceptor.is_open()) co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, error));
      continue;
    }
    if (clients.size() >= kMaxClients) {
      clients.front()->close(error);
      clients.pop_front();
    }
    clients.push_back(std::make_shared<tcp::socket>(std::move(socket)));
    asio::co_spawn(
        acceptor.get_executor(), [self, client = clients.back()] { return self->serve(client); },
        asio::detached);
  }
}

HealthEndpoint::HealthEndpoint(asio::io_context& context, const std::string& listen, HealthAnswers answers)
    : state_(std::make_shared<State>(context, listen, std::move(answers))) {
  asio::co_spawn(
      context, [state = state_] { return state->accept(); }, asio::detached);
}

HealthEndpoint::~HealthEndpoint() {
  asio::error_code ignored;
  state_->acceptor.close(ignored);
}

std::string HealthEndpoint::address() const { return toString(state_->acceptor.local_endpoint()); }

}  // namespace lode::serve
