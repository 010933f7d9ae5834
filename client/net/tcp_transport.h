#pragma once

#include <functional>
#include <memory>

#include <asio/io_context.hpp>

#include "client/net/address.h"
#include "proto/messages.h"

namespace lode::net {

constexpr size_t kMaxReceivedBytes = 4u << 20;  ///< waiting to be taken; reading pauses above it
constexpr size_t kMaxUnsentBytes = 16u << 20;   ///< waiting to be sent; more is an error

/// A connection to a server, plain or under TLS, on a thread of its own, which the destructor joins (then it
/// is thread safe), or on the loop of a caller that steps many connections on one thread.
class TcpTransport {
 public:
  /// Starts to connect. @throws Error kIo if the system gives no thread.
  /// @param wake  called on the transport's thread, and must be quick, when there is something to take:
  /// bytes,
  ///              or the end of the connection.
  TcpTransport(Route route, std::function<void()> wake);
  /// The same on a loop that the caller runs, from whose thread all calls come, the destructor's too.
  /// @param io  outlives the transport.
  TcpTransport(asio::io_context& io, Route route, std::function<void()> wake);
  ~TcpTransport();
  TcpTransport(const TcpTransport&) = delete;
  TcpTransport& operator=(const TcpTransport&) = delete;

  /// Queues bytes; never waits. @throws Error kNetwork if the server takes nothing for too long.
  void send(proto::Bytes bytes);
  /// What has come since the last call; never waits.
  /// @throws Error kNetwork or kTimeout, once all bytes were taken, when the connection failed or ended; the
  ///         message names the address and the remedy.
  proto::Bytes takeReceived();

 private:
  struct State;
  struct Thread;
  std::unique_ptr<Thread> own_thread_;  ///< none on the caller's loop
  std::shared_ptr<State> state_;
};

}  // namespace lode::net
