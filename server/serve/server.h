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
  std::vector<std::filesystem::path> stores;       ///< .lode files, and folders of them
  std::string listen = "127.0.0.1:7400";           ///< ADDRESS:PORT, [V6]:PORT or NAME:PORT; port 0 picks one
  std::optional<int> listening_socket;             ///< instead: one that listens already; owned from then on
  std::string metrics;                             ///< the same, of metrics and health; empty: none
  bool public_ok = false;                          ///< may listen beyond loopback without tokens,
  bool insecure = false;                           ///< and without TLS
  std::filesystem::path token_file;                ///< empty: no token is asked for
  std::filesystem::path tls_certificate, tls_key;  ///< PEM; both or none
  bool proxy_protocol = false;                     ///< a balancer says first who the client is
  unsigned threads = 0;                            ///< 0: one a core
  uint32_t max_connections = proto::kMaxConnections;
  std::optional<uint32_t> max_connections_per_address;   ///< none: kMaxConnectionsPerAddress but for loopback
  uint64_t memory_budget_bytes = 0;                      ///< 0: an eighth of what there is
  uint32_t max_open_requests = proto::kMaxOpenRequests;  ///< of a connection
  uint32_t max_open_models = proto::kMaxOpenModels;      ///< of a connection
  uint64_t max_queued_answer_bytes = proto::kMaxQueuedAnswerBytes;  ///< that a connection has not read
  uint64_t bytes_per_second = 0;                                    ///< of blobs, in all; 0: no limit
  uint64_t bytes_per_second_per_connection = 0;
  std::chrono::milliseconds handshake_deadline = proto::kHandshakeDeadline;
  std::chrono::milliseconds idle_deadline = proto::kIdleDeadline;
  std::chrono::milliseconds write_deadline = proto::kWriteDeadline;
  std::chrono::milliseconds drain_delay{0};  ///< from stop() to the listener's close
  std::chrono::milliseconds drain_deadline = proto::kDrainDeadline;
  std::chrono::milliseconds look_at_stores_every{20};  ///< for changes in place
  LogOptions log;
};

/// Serves stores over TCP as docs/protocol.md says. Constructed, it listens; connections are answered while
/// run() runs.
class Server {
 public:
  /// Opens the stores and listens.
  /// @throws Error kUsage (no store, two models of one name, an address beyond loopback that was not
  /// allowed), kIo (a port in use, an unreadable file), kFormat (a damaged store); the message says what to
  /// do.
  explicit Server(ServeOptions options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  uint16_t port() const noexcept;
  std::string address() const;                        ///< "127.0.0.1:7400": where it listens
  std::optional<std::string> metricsAddress() const;  ///< none without metrics
  std::vector<std::string> models() const;            ///< names, sorted
  uint64_t memoryHeld() const noexcept;               ///< what connections hold of the budget; thread safe

  /// Answers connections until stop(); starts the threads and joins them. Call it once. @throws Error kIo.
  void run();

  /// Looks at stores, tokens and certificate again and goes on with what it finds; what is wrong with them is
  /// logged, and what there was stays. Takes as long as opening them. Thread safe.
  void reload();

  /// Is no longer ready; after the drain delay takes no more connections, says GoAway to those there are,
  /// lets their requests end and makes run() return, at the latest after the drain deadline. Called again,
  /// it ends the delay, or the wait for requests, that is under way. Thread safe, and
  /// good before run(); not for a signal handler.
  void stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lode::serve
