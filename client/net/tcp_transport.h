#pragma once

#include <functional>
#include <memory>

#include <asio/io_context.hpp>

#include "client/net/address.h"
#include "proto/messages.h"

namespace lode::net {

constexpr size_t kMaxReceivedBytes = 4u << 20;  ///< received and not taken; reading pauses above it
constexpr size_t kMaxUnsentBytes = 16u << 20;   ///< queued for sending; more is an error

/// A connection to a server, plain or with TLS. It runs on its own thread, which the destructor joins, and is
/// thread safe; or it runs on the caller's event loop, for many connections on one thread.
class TcpTransport {
 public:
  /// Starts to connect on a thread of its own. @throws Error kIo if no thread can be started.
  /// @param wake  called on the transport's thread when bytes or the end of the connection can be taken; must
  ///              return quickly.
  TcpTransport(Route route, std::function<void()> wake);
  /// Starts to connect on the caller's event loop. All calls, including the destructor, must come from the
  /// loop's thread. @param io  must outlive the transport.
  TcpTransport(asio::io_context& io, Route route, std::function<void()> wake);
  ~TcpTransport();
  TcpTransport(const TcpTransport&) = delete;
  TcpTransport& operator=(const TcpTransport&) = delete;

  /// Queues bytes; never blocks. @throws Error kNetwork if more than kMaxUnsentBytes are queued.
  void send(proto::Bytes bytes);
  /// Returns the bytes received since the last call; never blocks.
  /// @throws Error kNetwork or kTimeout after all bytes are taken, if the connection failed or ended.
  proto::Bytes takeReceived();

 private:
  struct State;
  struct Thread;
  std::unique_ptr<Thread> own_thread_;  ///< null on the caller's loop
  std::shared_ptr<State> state_;
};

}  // namespace lode::net
