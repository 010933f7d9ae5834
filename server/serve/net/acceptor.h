#pragma once

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
#include "server/serve/net/open_files.h"
#include "server/serve/net/refusals.h"
#include "server/serve/ops/log.h"
#include "server/serve/ops/metrics.h"

namespace lode::serve {

struct AcceptorOptions {
  bool count_addresses = true;    ///< false behind a balancer: its header says them later
  uint64_t connection_bytes = 0;  ///< what each is taken to cost
};

/// Takes connections in, or says why not. Not thread safe; it lives on the thread of its context.
class Acceptor {
 public:
  /// What a connection that was let in is handed to.
  using Hand = std::function<void(asio::ip::tcp::socket, Place, MemoryAccount, std::string client)>;

  Acceptor(asio::ip::tcp::acceptor acceptor, AcceptorOptions options, Admission& admission,
           MemoryBudget& budget, ThreadCounters& counters, Log& log, Hand hand);

  /// Until close(); whatever goes wrong with one connection, the next is taken. Call it again when something
  /// was thrown out of the context's run().
  void open();
  void close();
  /// What those who are refused expect to speak; none: nothing, their connections are plain.
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
  Hand hand_;
  std::shared_ptr<asio::ssl::context> tls_;
  Refusals refusals_;
  ReserveDescriptor reserve_;
  asio::steady_timer sweep_;
  bool accepting_ = false, sweeping_ = false;
};

}  // namespace lode::serve
