#include <csignal>
#include <exception>
#include <memory>
#include <thread>

#include <asio.hpp>

#include "server/app/command.h"
#include "server/app/json_output.h"
#include "server/serve/server.h"

namespace lode::app {
namespace {

/// Stops a server at SIGTERM or SIGINT, from its construction to its end.
class StopOnSignal {
 public:
  explicit StopOnSignal(serve::Server& server) : signals_(context_, SIGTERM, SIGINT) {
    signals_.async_wait([&server](const asio::error_code& error, int) {
      if (!error) server.stop();
    });
    thread_ = std::jthread([this] { context_.run(); });
  }
  ~StopOnSignal() { context_.stop(); }
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

 private:
  asio::io_context context_{1};
  asio::signal_set signals_;
  std::jthread thread_;
};

void runServe(const serve::ServeOptions& options) {
  serve::Server server(options);
  StopOnSignal stop(server);
  printJson({{"listen", server.address()}, {"metrics", nullptr}, {"models", server.models()}});
  server.run();
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
  command->add_flag("--public", options->public_ok, "allow an address beyond loopback");
  command->add_flag("--insecure", options->insecure, "allow it without tokens and TLS");
  command->add_option("--threads", options->threads, "threads to use (default: one a core)")
      ->check(CLI::Range(1u, 1024u));
  command->add_option("--max-connections", options->max_connections, "connections at a time")
      ->check(CLI::Range(1u, 1000000u))
      ->capture_default_str();
  addMissingOption(*command, "--metrics", "address and port of the metrics");
  addMissingOption(*command, "--token-file", "tokens that clients must show");
  addMissingOption(*command, "--tls-cert", "certificate chain");
  addMissingOption(*command, "--tls-key", "private key");
  addMissingFlag(*command, "--proxy-protocol", "expect HAProxy's header on every connection");
  addMissingOption(*command, "--drain-delay", "seconds to go on accepting after SIGTERM");
  options->log = [](std::string_view line) {
    std::fprintf(stderr, "lodestreamd: %.*s\n", static_cast<int>(line.size()), line.data());
  };
  command->callback([options] { runServe(*options); });
}

}  // namespace lode::app
