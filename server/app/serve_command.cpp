#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include <asio/io_context.hpp>
#include <asio/post.hpp>
#include <asio/signal_set.hpp>
#include <asio/thread_pool.hpp>

#include "common/command_line.h"
#include "common/start_thread.h"
#include "server/app/command.h"
#include "server/app/json_output.h"
#include "server/app/service_notice.h"
#include "server/serve/server.h"

namespace lode::app {
namespace {

constexpr std::chrono::seconds kReloadPatience(2);  ///< of a server that has stopped

volatile std::sig_atomic_t asked_to_reload = 0;

/// Until Signals takes SIGHUP: what was read before it came is to be read again once the server is there.
void noteReloads() {
  std::signal(SIGHUP, [](int) { asked_to_reload = 1; });
}

/// Stops a server at SIGTERM or SIGINT and reloads it at SIGHUP, from its construction to its end.
class Signals {
 public:
  explicit Signals(serve::Server& server) : server_(server), signals_(context_, SIGTERM, SIGINT, SIGHUP) {
    // Never destroyed: a signal that comes while the process ends shall not kill it.
    [[maybe_unused]] static const auto* const kept =
        new asio::signal_set(*new asio::io_context, SIGTERM, SIGINT, SIGHUP);
    if (asked_to_reload != 0) askToReload();
    wait();
    thread_ = startThread<std::jthread>("for signals", [this] { context_.run(); });
  }
  ~Signals() {
    context_.stop();
    reloads_.join();
  }
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

  /// @return false if a reload takes longer than that.
  bool reloadsEndWithin(std::chrono::seconds patience) {
    std::unique_lock lock(mutex_);
    return reload_ended_.wait_for(lock, patience, [this] { return reloads_open_ == 0; });
  }

 private:
  void wait() {
    signals_.async_wait([this](const asio::error_code& error, int signal) {
      if (error) return;
      if (signal == SIGHUP) {
        askToReload();
      } else {
        stopping_ = true;
        notifyService("STOPPING=1");
        server_.stop();
      }
      wait();
    });
  }

  /// One that has not begun does for more that are asked for.
  void askToReload() {
    const std::lock_guard lock(mutex_);
    if (std::exchange(reload_waits_, true)) return;
    ++reloads_open_;
    asio::post(reloads_, [this] { reload(); });
  }

  void reload() {
    std::unique_lock lock(mutex_);
    reload_waits_ = false;
    lock.unlock();
    if (!stopping_) {
      notifyService("RELOADING=1\nMONOTONIC_USEC=" + monotonicMicroseconds());
      server_.reload();
      if (!stopping_) notifyService("READY=1");
    }
    lock.lock();
    --reloads_open_;
    reload_ended_.notify_all();
  }

  serve::Server& server_;
  asio::io_context context_{1};
  asio::signal_set signals_;
  asio::thread_pool reloads_{1};  ///< a thread of their own: a disk may hang, and the server be stopped
  std::atomic<bool> stopping_{false};
  std::mutex mutex_;  ///< of the next three
  std::condition_variable reload_ended_;
  bool reload_waits_ = false;  ///< and has not begun
  int reloads_open_ = 0;
  std::jthread thread_;
};

void runServe(serve::ServeOptions options) {
  options.listening_socket = socketOfService();
  std::signal(SIGPIPE, SIG_IGN);  // who reads our output may go; we stay
  noteReloads();
  serve::Server server(std::move(options));
  Signals signals(server);
  Json metrics = nullptr;
  if (const auto address = server.metricsAddress()) metrics = *address;
  printJson({{"listen", server.address()}, {"metrics", metrics}, {"models", server.models()}});
  notifyService("READY=1");
  server.run();
  if (!signals.reloadsEndWithin(kReloadPatience)) std::_Exit(0);  // nothing ends the wait for a disk
}

constexpr double kLeastSeconds = 0.001;  // of a deadline: none would end every connection at once

/// An option of so many seconds, which may have a fraction.
void addSeconds(CLI::App& command, const std::string& name, std::chrono::milliseconds& value, double least,
                const std::string& help) {
  command
      .add_option_function<double>(
          name, [&value](double seconds) { value = std::chrono::milliseconds(std::llround(1000 * seconds)); },
          help)
      ->check(numberFrom(least, 86400.0))
      ->type_name("SECONDS")
      ->default_str(std::to_string(value.count() / 1000));
}

void addRates(CLI::App& command, serve::ServeOptions& options) {
  const auto add = [&](const char* name, uint64_t& bytes_per_second, const char* help) {
    addByteSize(command, name, bytes_per_second, help, 1000, uint64_t{1} << 40);
  };
  add("--max-rate", options.bytes_per_second, "bytes of blobs a second in all, as 50MB (default: no limit)");
  add("--max-rate-per-connection", options.bytes_per_second_per_connection, "the same for each connection");
}

void addLimits(CLI::App& command, serve::ServeOptions& options) {
  command.add_option("--max-connections", options.max_connections, "connections at a time")
      ->check(CLI::Range(1u, 1000000u))
      ->capture_default_str();
  command
      .add_option("--max-connections-per-address", options.max_connections_per_address,
                  "of one client's address (default: " + std::to_string(proto::kMaxConnectionsPerAddress) +
                      ", loopback not limited)")
      ->check(CLI::Range(1u, 1000000u));
  command.add_option("--max-requests", options.max_open_requests, "open requests of a connection")
      ->check(CLI::Range(1u, proto::kMaxOpenRequests))
      ->capture_default_str();
  command.add_option("--max-open-models", options.max_open_models, "models that a connection has open")
      ->check(CLI::Range(1u, proto::kMaxOpenModels))
      ->capture_default_str();
  addByteSize(command, "--max-queued-bytes", options.max_queued_answer_bytes,
              "answers that a connection has not read before nothing more is read from it, as 16KB", 1000,
              proto::kMaxQueuedAnswerBytes)
      ->default_str(std::to_string(options.max_queued_answer_bytes));
  addByteSize(command, "--memory-budget", options.memory_budget_bytes,
              "bytes for all connections together, as 512MB or 2GiB (default: an eighth of what there is)",
              1'000'000, uint64_t{1} << 50);
  addSeconds(command, "--handshake-deadline", options.handshake_deadline, kLeastSeconds,
             "from the connection to Hello");
  addSeconds(command, "--idle-deadline", options.idle_deadline, kLeastSeconds,
             "from one frame of a client to the next");
  addSeconds(command, "--write-deadline", options.write_deadline, kLeastSeconds,
             "for a write that a client does not take");
  addSeconds(command, "--drain-delay", options.drain_delay, 0,
             "to go on accepting after SIGTERM; a second one ends it");
  addSeconds(command, "--drain-deadline", options.drain_deadline, 0, "for open requests, after that");
}

}  // namespace

void addServeCommand(CLI::App& program) {
  const auto options = std::make_shared<serve::ServeOptions>();
  CLI::App* command = addCommand(program, "serve", "Serve stores over TCP");
  command->add_option("stores", options->stores, "stores, and folders of them")
      ->required()
      ->type_name("STORE|DIR");
  command->add_option("--listen", options->listen, "address and port; port 0 picks one")
      ->type_name("ADDR:PORT")
      ->capture_default_str();
  command->add_flag("--public", options->public_ok, "allow an address beyond loopback without tokens");
  command->add_flag("--insecure", options->insecure, "allow an address beyond loopback without TLS");
  command->add_option("--token-file", options->token_file, "tokens that clients must show")
      ->type_name("FILE");
  command->add_option("--tls-cert", options->tls_certificate, "certificate chain, PEM")->type_name("FILE");
  command->add_option("--tls-key", options->tls_key, "its private key, PEM")->type_name("FILE");
  command->add_flag("--proxy-protocol", options->proxy_protocol,
                    "expect HAProxy's header (version 1 or 2) on every connection");
  command->add_option("--metrics", options->metrics, "address and port of metrics and health")
      ->type_name("ADDR:PORT");
  command->add_flag("--log-json", options->log.json, "a JSON object a line of the log");
  command->add_option("--threads", options->threads, "threads to use (default: one a core)")
      ->check(CLI::Range(1u, 1024u));
  addLimits(*command, *options);
  addRates(*command, *options);
  command->callback([options] { runServe(*options); });
}

}  // namespace lode::app
