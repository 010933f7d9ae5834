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

/// What is swapped whole at a reload.
struct Published {
  ServedSet served;
  std::shared_ptr<asio::ssl::context> tls;
};

/// One thread of the server: its event loop and the connections that live on it. Functions are thread safe
/// unless they say otherwise.
class Worker {
 public:
  Worker(Published published, Log& log, ThreadCounters& counters, asio::thread_pool& readers,
         MemoryBudget& budget, ByteRate& rate, ConnectionLimits limits);

  /// Once. @throws std::system_error.
  void start(Clock::duration sweep_every);
  void halt() { context_.stop(); }
  void join();

  /// How many connections it has or was given.
  uint32_t load() const noexcept { return load_.load(std::memory_order_relaxed); }
  /// Takes a connection over. @throws std::bad_alloc; the connection is closed then.
  void give(asio::ip::tcp::socket socket, Place place, MemoryAccount memory, std::string client);
  void publish(const Published& published);
  void drain(const std::string& reason);

 private:
  asio::awaitable<void> sweep(Clock::duration every);
  void sweepNow(Clock::time_point now);
  void giveUpTheGreediest();
  void admit(asio::ip::tcp::socket socket, Place place, MemoryAccount memory, std::string client);

  MemoryBudget& budget_;
  ConnectionLimits limits_;
  std::atomic<uint32_t> load_{0};
  std::string draining_;  ///< the reason; empty: it is not
  ConnectionHost host_;
  asio::io_context context_{1};
  asio::executor_work_guard<asio::io_context::executor_type> guard_;
  asio::steady_timer tick_;
  std::thread thread_;
};

}  // namespace lode::serve
