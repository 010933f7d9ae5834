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

/// Longest time that a stopped server waits for a running reload.
constexpr std::chrono::seconds kReloadPatience(2);

volatile std::sig_atomic_t asked_to_reload = 0;

/// Records SIGHUP until a Signals object exists. If a SIGHUP was recorded, the Signals object reloads the
/// files, because the server may have read them before the signal.
void noteReloads() {
  std::signal(SIGHUP, [](int) { asked_to_reload = 1; });
}

/// Stops the server at SIGTERM or SIGINT and reloads it at SIGHUP.
class Signals {
 public:
  explicit Signals(serve::Server& server) : server_(server), signals_(context_, SIGTERM, SIGINT, SIGHUP) {
    // This set is never destroyed: otherwise a signal during exit would kill the process.
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

  /// Waits for all running and queued reloads. @return false if they take longer than `patience`.
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

  /// Starts a reload, unless another reload is queued and has not begun.
  void askToReload() {
    const std::lock_guard lock(mutex_);
    if (std::exchange(reload_queued_, true)) return;
    ++reloads_open_;
    asio::post(reloads_, [this] { reload(); });
  }

  void reload() {
    std::unique_lock lock(mutex_);
    reload_queued_ = false;
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
  asio::thread_pool reloads_{1};  ///< thread for reloads, so that the server can stop while a disk hangs
  std::atomic<bool> stopping_{false};
  std::mutex mutex_;  ///< guards the next three members
  std::condition_variable reload_ended_;
  bool reload_queued_ = false;  ///< true while a reload is queued and has not begun
  int reloads_open_ = 0;
  std::jthread thread_;
};

void runServe(serve::ServeOptions options) {
  options.listening_socket = socketOfService();
  std::signal(SIGPIPE, SIG_IGN);  // go on even if the reader of stdout exits
  noteReloads();
  serve::Server server(std::move(options));
  Signals signals(server);
  Json metrics = nullptr;
  if (const auto address = server.metricsAddress()) metrics = *address;
  Json http = nullptr;
  if (const auto address = server.httpAddress()) http = *address;
  Json link = nullptr;
  if (const auto of_page = server.pageLink()) link = *of_page;
  Json skipped = Json::array();
  for (const serve::SkippedStore& store : server.skipped())
    skipped.push_back({{"model", store.model}, {"why", store.why}});
  printJson({{"listen", server.address()},
             {"http", http},
             {"link", link},
             {"metrics", metrics},
             {"models", server.models()},
             {"skipped", std::move(skipped)}});
  notifyService("READY=1");
  server.run();
  if (!signals.reloadsEndWithin(kReloadPatience))
    std::_Exit(0);  // exit at once, because a reload that waits for a disk would block a normal exit
}

// Smallest deadline; a deadline of 0 would end every connection at once.
constexpr double kLeastSeconds = 0.001;

/// Adds an option for a number of seconds, which may have fractions.
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
  add("--max-rate", options.bytes_per_second,
      "maximum bytes of blobs per second of all connections together, such as 50MB (default: no limit)");
  add("--max-rate-per-connection", options.bytes_per_second_per_connection,
      "maximum bytes of blobs per second of each connection (default: no limit)");
}

void addLimits(CLI::App& command, serve::ServeOptions& options) {
  command.add_option("--max-connections", options.max_connections, "maximum number of connections")
      ->check(CLI::Range(1u, 1000000u))
      ->capture_default_str();
  command
      .add_option("--max-connections-per-address", options.max_connections_per_address,
                  "maximum number of connections from one address (default: " +
                      std::to_string(proto::kMaxConnectionsPerAddress) + "; no limit for loopback)")
      ->check(CLI::Range(1u, 1000000u));
  command
      .add_option("--max-requests", options.max_open_requests,
                  "maximum number of open requests of a connection")
      ->check(CLI::Range(1u, proto::kMaxOpenRequests))
      ->capture_default_str();
  command
      .add_option("--max-open-models", options.max_open_models,
                  "maximum number of open models of a connection")
      ->check(CLI::Range(1u, proto::kMaxOpenModels))
      ->capture_default_str();
  addByteSize(command, "--max-queued-bytes", options.max_queued_answer_bytes,
              "bytes of unread answers at which the server stops reading from a connection, such as 16KB",
              1000, proto::kMaxQueuedAnswerBytes)
      ->default_str(std::to_string(options.max_queued_answer_bytes));
  addByteSize(
      command, "--memory-budget", options.memory_budget_bytes,
      "memory of all connections together, such as 512MB or 2GiB (default: an eighth of the memory that the "
      "process may use)",
      1'000'000, uint64_t{1} << 50);
  addByteSize(command, "--http-memory", options.http_memory_bytes,
              "memory of the tiles and pages that --http keeps", 1'000'000, uint64_t{1} << 50)
      ->default_str("256MB");
  addSeconds(command, "--handshake-deadline", options.handshake_deadline, kLeastSeconds,
             "longest time from the connection to Hello");
  addSeconds(command, "--idle-deadline", options.idle_deadline, kLeastSeconds,
             "longest time from one frame of a client to the next");
  addSeconds(command, "--write-deadline", options.write_deadline, kLeastSeconds,
             "longest time in which a client reads none of the data that waits for it");
  addSeconds(command, "--read-deadline", options.read_deadline, kLeastSeconds,
             "longest time of a read from a store; its request then ends with an error");
  addSeconds(
      command, "--drain-delay", options.drain_delay, 0,
      "time after SIGTERM in which the server still accepts connections; a second SIGTERM ends this time");
  addSeconds(command, "--drain-deadline", options.drain_deadline, 0,
             "longest time for open requests after the delay");
}

}  // namespace

void addServeCommand(CLI::App& program) {
  const auto options = std::make_shared<serve::ServeOptions>();
  CLI::App* command = addCommand(program, "serve", "Serve stores over TCP");
  command->add_option("stores", options->stores, ".lode files, and folders of .lode files")
      ->required()
      ->type_name("STORE|DIR");
  command
      ->add_option("--listen", options->listen, "address and port to listen on; port 0 selects a free port")
      ->type_name("ADDR:PORT")
      ->capture_default_str();
  command
      ->add_option("--http", options->http,
                   "address and port for HTTP, which serves the stores as 3D Tiles to browsers and viewers")
      ->type_name("ADDR:PORT");
  command->add_flag("--strict", options->strict,
                    "refuse to start if a store in a folder cannot be opened (default: skip the store)");
  command->add_flag("--public", options->public_ok,
                    "allow an address beyond loopback without tokens, and metrics there");
  command->add_flag(
      "--insecure", options->insecure,
      "allow an address beyond loopback without TLS, and a private key that other users can read");
  command->add_option("--token-file", options->token_file, "file with the tokens that clients must present")
      ->type_name("FILE");
  command->add_option("--tls-cert", options->tls_certificate, "certificate chain, PEM")->type_name("FILE");
  command->add_option("--tls-key", options->tls_key, "private key of the certificate, PEM")
      ->type_name("FILE");
  command->add_flag("--proxy-protocol", options->proxy_protocol,
                    "expect HAProxy's header (version 1 or 2) on every connection");
  command->add_option("--metrics", options->metrics, "address and port of the metrics and health endpoint")
      ->type_name("ADDR:PORT");
  command->add_flag("--log-json", options->log.json, "write each log line as a JSON object");
  command->add_option("--threads", options->threads, "number of threads (default: one for each core)")
      ->check(CLI::Range(1u, 1024u));
  addLimits(*command, *options);
  addRates(*command, *options);
  command->callback([options] { runServe(*options); });
}

}  // namespace lode::app
