#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace lode::serve {

struct ServeOptions {
  std::vector<std::filesystem::path> stores;  ///< .lode files, and folders of them
  std::string listen = "127.0.0.1:7400";      ///< ADDRESS:PORT, [V6]:PORT or NAME:PORT; port 0 picks one
  bool public_ok = false;                     ///< may listen beyond loopback,
  bool insecure = false;                      ///< and that without tokens and TLS
  unsigned threads = 0;                       ///< 0: one a core
  uint32_t max_connections = 10000;
  std::chrono::milliseconds handshake_deadline{10'000};  ///< until Hello has come
  std::chrono::milliseconds idle_deadline{120'000};      ///< without a frame from the client
  std::chrono::milliseconds drain_deadline{5'000};       ///< for open wishes, after stop()
  /// One line for the operator (a damaged blob, no file handles left). Called from any thread.
  std::function<void(std::string_view)> log = [](std::string_view) {};
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
  std::string address() const;              ///< "127.0.0.1:7400": where it listens
  std::vector<std::string> models() const;  ///< names, sorted

  /// Answers connections until stop(); starts the threads and joins them. Call it once. @throws Error kIo.
  void run();

  /// Takes no more connections, says GoAway to those there are, lets their wishes end and makes run() return,
  /// at the latest after the drain deadline. Thread safe, and good before run(); not for a signal handler.
  void stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lode::serve
