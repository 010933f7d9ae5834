#include "server/serve/server.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <system_error>
#include <thread>
#include <unordered_set>
#include <utility>

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/post.hpp>
#include <asio/redirect_error.hpp>
#include <asio/steady_timer.hpp>
#include <asio/thread_pool.hpp>
#include <asio/use_awaitable.hpp>
#include <netinet/tcp.h>

#include "common/error.h"
#include "server/serve/connection.h"
#include "server/serve/listen_address.h"
#include "server/serve/model_set.h"
#include "server/serve/session.h"

namespace lode::serve {

namespace {

using asio::ip::tcp;

constexpr size_t kReaderThreads = 4;           ///< that may wait for the disk
constexpr uint32_t kMaxRefusedLingering = 64;  ///< connections above the limit that are told so
constexpr auto kAcceptPause = std::chrono::milliseconds(100);  ///< after the system refused a connection
constexpr int kNotSentLowBytes =
    64 << 10;  ///< TCP_NOTSENT_LOWAT: what waits in the kernel cannot be overtaken

}  // namespace

/// One thread of the server: its event loop and the connections that live on it.
class Worker {
 public:
  Worker() : context_(1), guard_(context_.get_executor()), tick_(context_) {}

  asio::io_context& context() noexcept { return context_; }
  uint32_t load() const noexcept { return load_.load(std::memory_order_relaxed); }
  BufferPool& buffers() noexcept { return buffers_; }

  void start(Clock::duration sweep_every) {
    asio::co_spawn(context_, sweep(sweep_every), asio::detached);
    thread_ = std::thread([this] { context_.run(); });
  }
  void halt() { context_.stop(); }
  void join() {
    if (thread_.joinable()) thread_.join();
  }

  void reserve() noexcept { load_.fetch_add(1, std::memory_order_relaxed); }
  void add(Connection& connection) { connections_.insert(&connection); }
  void remove(Connection& connection) noexcept {
    connections_.erase(&connection);
    load_.fetch_sub(1, std::memory_order_relaxed);
  }
  void drain(const std::string& reason) {
    asio::post(context_, [this, reason] {
      for (Connection* connection : connections_) connection->drain(reason);
    });
  }

 private:
  asio::awaitable<void> sweep(Clock::duration every) {
    asio::error_code error;
    while (!error) {
      tick_.expires_after(every);
      co_await tick_.async_wait(asio::redirect_error(asio::use_awaitable, error));
      const auto now = Clock::now();
      for (Connection* connection : connections_) connection->sweep(now);
    }
  }

  std::atomic<uint32_t> load_{0};
  std::unordered_set<Connection*> connections_;  ///< touched on this thread only
  BufferPool buffers_;
  asio::io_context context_;
  asio::executor_work_guard<asio::io_context::executor_type> guard_;
  asio::steady_timer tick_;
  std::thread thread_;
};

struct Server::State {
  explicit State(ServeOptions given)
      : options(std::move(given)), models(options.stores, options.log), acceptor(context) {
    listen();
  }

  ~State() {
    halt();
    for (auto& worker : workers) worker->join();
    readers.join();  // before the loops go, which own what the readers write into
  }

  void listen();
  void run();
  void halt();
  void stopNow();
  void connectionEnded();
  asio::awaitable<void> accept();
  void hand(tcp::socket socket);
  void admit(Worker& worker, tcp::socket socket, bool full);

  ServeOptions options;
  ModelSet models;
  std::atomic<uint32_t> connections{0};
  std::atomic<bool> draining{false};
  std::string address;
  uint16_t port = 0;
  asio::io_context context{1};  ///< accepts; runs in run()'s thread
  tcp::acceptor acceptor;
  std::vector<std::unique_ptr<Worker>> workers;
  asio::thread_pool readers{kReaderThreads};
};

namespace {

/// A connection that the server's books know of.
class CountedConnection : public Connection {
 public:
  CountedConnection(tcp::socket socket, ConnectionHost host, SessionLimits limits, Worker& worker,
                    std::function<void()> ended)
      : Connection(std::move(socket), host, limits), worker_(worker), ended_(std::move(ended)) {
    worker_.add(*this);
  }
  ~CountedConnection() override {
    worker_.remove(*this);
    ended_();
  }

 private:
  Worker& worker_;
  std::function<void()> ended_;
};

}  // namespace

void Server::State::listen() {
  const ListenAddress wanted = parseListenAddress(options.listen);
  asio::error_code error;
  const auto found =
      tcp::resolver(context).resolve(wanted.host, std::to_string(wanted.port), tcp::resolver::passive, error);
  if (error || found.empty())
    throw Error(ErrorCode::kUsage, "cannot listen on " + options.listen + ": " + error.message() +
                                       "; name an address of this machine");
  const tcp::endpoint endpoint = found.begin()->endpoint();
  if (!endpoint.address().is_loopback() && !(options.public_ok && options.insecure))
    throw Error(ErrorCode::kUsage,
                "listening on " + options.listen +
                    " would let other machines in: give --public, and --insecure with it as there are no "
                    "tokens and no TLS yet, or listen on 127.0.0.1");
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(tcp::acceptor::max_listen_connections, error);
  if (error)
    throw Error(ErrorCode::kIo, "cannot listen on " + options.listen + ": " + error.message() +
                                    "; stop what uses it or choose another with --listen (port 0 picks a "
                                    "free one)");
  const tcp::endpoint local = acceptor.local_endpoint();
  port = local.port();
  const std::string host = local.address().to_string();
  address = (local.address().is_v6() ? "[" + host + "]" : host) + ":" + std::to_string(local.port());
}

void Server::State::run() {
  const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
  const unsigned threads = options.threads == 0 ? cores : options.threads;
  const auto shortest = std::min(options.handshake_deadline, options.idle_deadline) / 4;
  const auto sweep_every =
      std::clamp<std::chrono::milliseconds>(shortest, std::chrono::milliseconds(5), std::chrono::seconds(1));
  try {
    for (unsigned i = 0; i < threads; ++i) workers.push_back(std::make_unique<Worker>());
    for (auto& worker : workers) worker->start(sweep_every);
  } catch (const std::system_error& error) {
    throw Error(ErrorCode::kIo, "cannot start " + std::to_string(threads) + " threads: " + error.what() +
                                    "; give a smaller --threads");
  }
  asio::co_spawn(context, accept(), asio::detached);
  const auto guard = asio::make_work_guard(context);
  context.run();
  halt();
  for (auto& worker : workers) worker->join();
}

void Server::State::halt() {
  context.stop();
  for (auto& worker : workers) worker->halt();
}

void Server::State::stopNow() {
  if (draining.exchange(true)) return;
  asio::error_code ignored;
  acceptor.close(ignored);
  for (auto& worker : workers) worker->drain("the server is stopping");
  const auto deadline = std::make_shared<asio::steady_timer>(context, options.drain_deadline);
  deadline->async_wait([this, deadline](const asio::error_code&) { context.stop(); });
  if (connections == 0) context.stop();
}

void Server::State::connectionEnded() {
  if (connections.fetch_sub(1) == 1 && draining) context.stop();
}

asio::awaitable<void> Server::State::accept() {
  while (acceptor.is_open()) {
    tcp::socket socket(context);
    asio::error_code error;
    co_await acceptor.async_accept(socket, asio::redirect_error(asio::use_awaitable, error));
    if (!acceptor.is_open()) co_return;
    std::string failure = error.message();
    try {
      if (!error) {
        hand(std::move(socket));
        continue;
      }
    } catch (const std::exception& thrown) {  // no memory for it
      failure = thrown.what();
    }
    options.log("a connection could not be accepted: " + failure);
    asio::steady_timer pause(context, kAcceptPause);
    co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, error));
  }
}

void Server::State::hand(tcp::socket socket) {
  const uint32_t already = connections.load();
  const bool full = already >= options.max_connections;
  if (already >= uint64_t{options.max_connections} + kMaxRefusedLingering) return;

  asio::error_code error;
  socket.set_option(tcp::no_delay(true), error);
  using NotSentLow = asio::detail::socket_option::integer<IPPROTO_TCP, TCP_NOTSENT_LOWAT>;
  socket.set_option(NotSentLow(kNotSentLowBytes), error);

  Worker& worker = **std::ranges::min_element(workers, {}, [](const auto& w) { return w->load(); });
  const auto protocol = acceptor.local_endpoint(error).protocol();
  tcp::socket moved(worker.context());
  const auto handle = socket.release(error);
  if (error) return;
  moved.assign(protocol, handle, error);
  if (error) return;
  worker.reserve();
  connections.fetch_add(1);
  asio::post(worker.context(), [this, &worker, full, moved = std::move(moved)]() mutable {
    admit(worker, std::move(moved), full);
  });
}

void Server::State::admit(Worker& worker, tcp::socket socket, bool full) {
  try {
    const ConnectionHost host{&models, &readers, &worker.buffers()};
    const SessionLimits limits{proto::kMaxOpenWishes, options.handshake_deadline, options.idle_deadline};
    const auto connection = std::make_shared<CountedConnection>(std::move(socket), host, limits, worker,
                                                                [this] { connectionEnded(); });
    if (full)
      connection->startRefusing(proto::WireError::kLimit,
                                "this server has its " + std::to_string(options.max_connections) +
                                    " connections; try again later, or another server");
    else
      connection->start();
    if (draining) connection->drain("the server is stopping");
  } catch (const std::exception& error) {  // no memory for it; the others go on
    options.log(std::string("a connection was given up: ") + error.what());
  }
}

Server::Server(ServeOptions options) : state_(std::make_unique<State>(std::move(options))) {}
Server::~Server() = default;

uint16_t Server::port() const noexcept { return state_->port; }

std::string Server::address() const { return state_->address; }

std::vector<std::string> Server::models() const {
  std::vector<std::string> names;
  for (const OfferedModel& model : state_->models.offered()) names.push_back(model.summary.name);
  return names;
}

void Server::run() { state_->run(); }

void Server::stop() {
  asio::post(state_->context, [state = state_.get()] { state->stopNow(); });
}

}  // namespace lode::serve
