#pragma once

#include <functional>
#include <memory>

#include <asio/io_context.hpp>

#include "client/net/address.h"
#include "proto/messages.h"

namespace lode::net {

/// Number of received bytes, not yet taken, at which the transport pauses reading.
constexpr size_t kMaxReceivedBytes = 1u << 20;
/// Limit for the bytes queued for sending; exceeding it is an error.
constexpr size_t kMaxUnsentBytes = 16u << 20;

/// A connection to a server, plain or with TLS. The first constructor runs the connection on its own thread,
/// which the destructor joins; the transport is then thread safe. The second constructor runs the connection
/// on the caller's event loop, so that many connections can share one thread.
class TcpTransport {
 public:
  /// Starts to connect on a thread of its own. @throws Error kIo if no thread can be started.
  /// @param wake  called on the transport's thread when bytes or the end of the connection can be taken; must
  ///              return quickly.
  TcpTransport(Route route, std::function<void()> wake);
  /// Starts to connect on the caller's event loop. Call all functions, including the destructor, on the
  /// loop's thread. @param io  event loop, which must outlive the transport.
  TcpTransport(asio::io_context& io, Route route, std::function<void()> wake);
  ~TcpTransport();
  TcpTransport(const TcpTransport&) = delete;
  TcpTransport& operator=(const TcpTransport&) = delete;

  /// Returns true if at most proto::kMaxQueuedAnswerBytes wait to be sent. The transport calls `wake` when
  /// the result changes from false to true.
  bool hasRoom() const;
  /// Queues bytes; never blocks. @throws Error kNetwork if more than kMaxUnsentBytes are queued.
  void send(proto::Bytes bytes);
  /// Returns the bytes received since the last call; never blocks.
  /// @throws Error kNetwork or kTimeout after all bytes are taken, if the connection failed or ended.
  proto::Bytes takeReceived();

 private:
  struct State;
  struct Thread;
  std::unique_ptr<Thread> own_thread_;  ///< null if the transport runs on the caller's event loop
  std::shared_ptr<State> state_;
};

}  // namespace lode::net
