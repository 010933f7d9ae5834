#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include <asio/awaitable.hpp>
#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>

#include "server/serve/net/connection.h"

namespace lode::serve {

/// State of the server that a reload replaces in a single step.
struct Published {
  ServedSet served;
  std::shared_ptr<asio::ssl::context> tls;
};

enum class ClientProtocol : uint8_t {
  kNative,  ///< docs/protocol.md
  kHttp,
};

/// Parts of the server that all workers share. They outlive the workers.
struct WorkerShared {
  Log& log;
  DiskReaders& readers;
  MemoryBudget& budget;
  ByteRate& rate;
  WrongTokens& wrong_tokens;
  ConnectionLimits limits;
  HttpFiles* http = nullptr;  ///< null without HTTP
  bool is_public = false;     ///< --public is given
};

/// One thread of the server with its event loop and connections. Thread safe, except for construction,
/// start() and join().
class Worker {
 public:
  Worker(Published published, const WorkerShared& shared, ThreadCounters& counters);

  /// Starts the thread. Call it once. @throws std::system_error.
  void start(Clock::duration sweep_every);
  void halt() { context_.stop(); }
  void join();

  /// Returns the number of connections, including those that give() has queued.
  uint32_t load() const noexcept { return load_.load(std::memory_order_relaxed); }
  /// Takes over a connection. If memory runs out, closes the connection and throws std::bad_alloc.
  void give(asio::ip::tcp::socket socket, Slot slot, MemoryAccount memory, std::string client,
            ClientProtocol protocol = ClientProtocol::kNative);
  void publish(const Published& published);
  void drain(const std::string& reason);

 private:
  asio::awaitable<void> sweep(Clock::duration every);
  void sweepNow(Clock::time_point now);
  void closeLargest();
  void admit(asio::ip::tcp::socket socket, Slot slot, MemoryAccount memory, std::string client,
             ClientProtocol protocol);
  template <typename Kind>
  void start(std::shared_ptr<Kind> connection);

  MemoryBudget& budget_;
  ConnectionLimits limits_;
  std::atomic<uint32_t> load_{0};
  std::string draining_;  ///< reason for the drain; empty while not draining
  ConnectionHost host_;
  asio::io_context context_{1};
  asio::executor_work_guard<asio::io_context::executor_type> guard_;
  asio::steady_timer tick_;
  std::thread thread_;
};

}  // namespace lode::serve
