#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/limits.h"
#include "server/serve/ops/log.h"

namespace lode::serve {

struct ServeOptions {
  std::vector<std::filesystem::path> stores;  ///< .lode files, and folders of .lode files
  std::string listen = "127.0.0.1:7400";      ///< ADDRESS:PORT, [V6]:PORT or NAME:PORT; port 0 picks one
  std::optional<int> listening_socket;        ///< an open listening socket to use instead; the server owns it
  std::string metrics;                        ///< address of the metrics and health port; empty: none
  bool public_ok = false;                     ///< allow listening beyond loopback without tokens
  bool insecure = false;                      ///< allow listening beyond loopback without TLS
  std::filesystem::path token_file;           ///< empty: clients need no token
  std::filesystem::path tls_certificate, tls_key;  ///< PEM files; give both or neither
  bool proxy_protocol = false;                     ///< expect a balancer's header first on each connection
  unsigned threads = 0;                            ///< 0: one for each core
  uint32_t max_connections = proto::kMaxConnections;
  std::optional<uint32_t>
      max_connections_per_address;   ///< default: kMaxConnectionsPerAddress, and no limit for loopback
  uint64_t memory_budget_bytes = 0;  ///< 0: defaultMemoryBudget()
  uint32_t max_open_requests = proto::kMaxOpenRequests;  ///< for each connection
  uint32_t max_open_models = proto::kMaxOpenModels;      ///< for each connection
  uint64_t max_queued_answer_bytes =
      proto::kMaxQueuedAnswerBytes;  ///< answers that a connection has not read
  uint64_t bytes_per_second = 0;     ///< rate of blobs in total; 0: no limit
  uint64_t bytes_per_second_per_connection = 0;
  std::chrono::milliseconds handshake_deadline = proto::kHandshakeDeadline;
  std::chrono::milliseconds idle_deadline = proto::kIdleDeadline;
  std::chrono::milliseconds write_deadline = proto::kWriteDeadline;
  std::chrono::milliseconds drain_delay{0};  ///< from stop() until the listener closes
  std::chrono::milliseconds drain_deadline = proto::kDrainDeadline;
  std::chrono::milliseconds check_stores_every{20};  ///< interval of checks for changed store files
  LogOptions log;
};

/// Serves stores over TCP with the protocol of docs/protocol.md. Listens once it is constructed and answers
/// connections while run() runs.
class Server {
 public:
  /// Opens the stores and listens.
  /// @throws Error kUsage (no store, two models of one name, an address beyond loopback that is not allowed),
  /// kIo (a port in use, an unreadable file), kFormat (a damaged store).
  explicit Server(ServeOptions options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  uint16_t port() const noexcept;
  std::string address() const;                        ///< address that it listens on: "127.0.0.1:7400"
  std::optional<std::string> metricsAddress() const;  ///< empty without metrics
  std::vector<std::string> models() const;            ///< sorted names
  uint64_t memoryHeld() const noexcept;  ///< bytes of the budget that connections hold; thread safe

  /// Starts the threads, answers connections until stop() and joins the threads. Call it once.
  /// @throws Error kIo.
  void run();

  /// Reads stores, tokens and certificate again. Logs errors and keeps the previous version of a part that
  /// cannot be read. Takes as long as opening them. Thread safe.
  void reload();

  /// Reports not ready, closes the listener after the drain delay, sends GoAway to all connections and ends
  /// run() once their requests are served, at the latest after the drain deadline. A second call ends the
  /// current wait. Thread safe, also before run(); not safe in a signal handler.
  void stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lode::serve
