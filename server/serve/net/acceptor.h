#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include <asio/awaitable.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>

#include "proto/messages.h"
#include "server/serve/memory/memory_budget.h"
#include "server/serve/net/admission.h"
#include "server/serve/net/refusals.h"
#include "server/serve/ops/log.h"
#include "server/serve/ops/metrics.h"

namespace lode::serve {

/// Raises the soft limit of open files of this process to its hard limit.
/// @return the new limit.
uint64_t raiseOpenFileLimit() noexcept;

/// A spare descriptor. When the process has no other descriptor left, the acceptor releases the spare one,
/// accepts one more connection and refuses the connection with a reason. Not thread safe.
class ReserveDescriptor {
 public:
  ReserveDescriptor() noexcept { acquire(); }
  ~ReserveDescriptor() { release(); }
  ReserveDescriptor(const ReserveDescriptor&) = delete;
  ReserveDescriptor& operator=(const ReserveDescriptor&) = delete;

  void release() noexcept;
  void acquire() noexcept;  ///< opens the spare descriptor again if the system has a descriptor left

 private:
  int descriptor_ = -1;
};

/// Returns an Error frame of the native protocol.
proto::Bytes nativeRefusal(const std::string& why);

struct AcceptorOptions {
  /// If true, limits connections per address at accept(). False behind a balancer, because its header with
  /// the client's address arrives later.
  bool count_addresses = true;
  uint64_t connection_bytes = 0;  ///< memory charged to the budget per connection
  /// A function that returns the bytes that tell a client why its connection is refused.
  std::function<proto::Bytes(const std::string& why)> refusal = nativeRefusal;
};

/// Accepts connections. If a connection would exceed a limit, refuses the connection with a reason. Runs on
/// the thread of its context. Not thread safe.
class Acceptor {
 public:
  /// A function that receives each admitted connection.
  using Handler = std::function<void(asio::ip::tcp::socket, Slot, MemoryAccount, std::string client)>;

  Acceptor(asio::ip::tcp::acceptor acceptor, AcceptorOptions options, Admission& admission,
           MemoryBudget& budget, ThreadCounters& counters, Log& log, Handler handler);

  /// Accepts connections until close() is called. An error of one connection does not stop the acceptor. Call
  /// open() again if the context's run() has thrown an exception.
  void open();
  void close();
  /// Sets the TLS context that encrypts refusals; null for connections without TLS.
  void setTls(std::shared_ptr<asio::ssl::context> tls) { tls_ = std::move(tls); }

 private:
  asio::awaitable<void> accept();
  asio::awaitable<void> sweepRefused();
  asio::awaitable<void> pauseAfter(const std::string& failure);
  void take(asio::ip::tcp::socket socket);
  void refuse(asio::ip::tcp::socket socket, RefusalReason reason, const std::string& why);
  void refuseForDescriptors();
  bool outOfDescriptors(const asio::error_code& error) const noexcept;

  asio::ip::tcp::acceptor acceptor_;
  AcceptorOptions options_;
  Admission& admission_;
  MemoryBudget& budget_;
  ThreadCounters& counters_;
  Log& log_;
  Handler handler_;
  std::shared_ptr<asio::ssl::context> tls_;
  Refusals refusals_;
  ReserveDescriptor reserve_;
  asio::steady_timer sweep_;
  bool accepting_ = false, sweeping_ = false;
};

}  // namespace lode::serve
