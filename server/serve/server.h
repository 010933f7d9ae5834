#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/limits.h"
#include "server/page/page_files.h"
#include "server/serve/ops/log.h"
#include "server/serve/session/catalog.h"
#include "server/serve/session/disk_readers.h"

namespace lode::serve {

constexpr uint64_t kHttpMemoryBytes = 256'000'000;

struct ServeOptions {
  std::vector<std::filesystem::path> stores;  ///< .lode files, and folders of .lode files
  /// ADDRESS:PORT, [V6]:PORT or NAME:PORT; port 0 selects a free port.
  std::string listen = "127.0.0.1:7400";
  /// Open listening socket that replaces `listen`; the server owns the socket.
  std::optional<int> listening_socket;
  /// Address of the port for HTTP, or empty for no such port. The port has the access rules and limits of
  /// `listen`.
  std::string http;
  uint64_t http_memory_bytes = kHttpMemoryBytes;               ///< memory of contents for HTTP
  std::span<const page::PageFile> page = page::builtInPage();  ///< page at "/"; empty: a list of the models
  /// Address of the port for metrics and health, or empty for no such port.
  std::string metrics;
  bool strict = false;     ///< refuse to start if a store in a folder cannot be opened
  bool public_ok = false;  ///< allow addresses beyond loopback without tokens, also for metrics
  /// Allow addresses beyond loopback without TLS, and a private key that others can read.
  bool insecure = false;
  std::filesystem::path token_file;                ///< file with the tokens; if empty, clients need no token
  std::filesystem::path tls_certificate, tls_key;  ///< PEM files; set both or neither
  bool proxy_protocol = false;  ///< expect a balancer's header at the start of a connection
  unsigned threads = 0;         ///< number of threads, or 0 for one per core
  uint32_t max_connections = proto::kMaxConnections;
  /// Largest number of connections per client address. If not set, the limit is kMaxConnectionsPerAddress,
  /// and loopback has no limit.
  std::optional<uint32_t> max_connections_per_address;
  uint64_t memory_budget_bytes = 0;  ///< memory for all connections, or 0 for defaultMemoryBudget()
  uint32_t max_open_requests = proto::kMaxOpenRequests;  ///< limit per connection
  uint32_t max_open_models = proto::kMaxOpenModels;      ///< limit per connection
  /// Limit per connection for answers that the client has not read yet.
  uint64_t max_queued_answer_bytes = proto::kMaxQueuedAnswerBytes;
  uint64_t bytes_per_second = 0;  ///< rate limit for the blobs of all connections together, or 0 for no limit
  uint64_t bytes_per_second_per_connection = 0;
  std::chrono::milliseconds handshake_deadline = proto::kHandshakeDeadline;
  std::chrono::milliseconds wrong_token_delay{50};  ///< delay of the answer to an address's first wrong token
  std::chrono::milliseconds idle_deadline = proto::kIdleDeadline;
  std::chrono::milliseconds write_deadline = proto::kWriteDeadline;
  std::chrono::milliseconds read_deadline = kReadDeadline;  ///< longest time of a read from the disk
  std::chrono::milliseconds drain_delay{0};                 ///< time from stop() until the listener closes
  std::chrono::milliseconds drain_deadline = proto::kDrainDeadline;
  std::chrono::milliseconds check_stores_every{20};  ///< interval of checks for changed store files
  LogOptions log;
};

/// Serves stores over TCP with the protocol of docs/protocol.md. The constructor starts to listen; run()
/// answers connections.
class Server {
 public:
  /// Opens the stores and listens. Unless `strict` is set, skips stores in folders that cannot be opened.
  /// @throws Error kUsage (no store, two models with the same name, an address beyond loopback that is not
  /// allowed), kIo (a port in use, an unreadable file), kFormat (a damaged store).
  explicit Server(ServeOptions options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  uint16_t port() const noexcept;
  std::string address() const;                        ///< address of the open port: "127.0.0.1:7400"
  std::optional<std::string> metricsAddress() const;  ///< nothing without a metrics port
  std::optional<std::string> httpAddress() const;     ///< nothing without a port for HTTP
  /// Address that shows the models in a browser, or nothing without a port for HTTP.
  std::optional<std::string> pageLink() const;
  std::vector<std::string> models() const;  ///< sorted names of all models
  /// Stores that the constructor skipped.
  const std::vector<SkippedStore>& skipped() const noexcept;
  uint64_t memoryHeld() const noexcept;  ///< bytes of the budget that connections hold; thread safe

  /// Starts the threads, answers connections until stop() and joins the threads. Call it once.
  /// @throws Error kIo.
  void run();

  /// Reads stores, tokens and certificate again, and returns when all of them are read. If one cannot be
  /// read, logs the error and keeps its previous version. Thread safe.
  void reload();

  /// Stops the server: reports "not ready", closes the listener after the drain delay, then sends GoAway to
  /// all connections. run() returns when the open requests are served, at the latest after the drain
  /// deadline. A second call ends the current wait. Thread safe, also before run(), but not safe in a signal
  /// handler.
  void stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lode::serve
