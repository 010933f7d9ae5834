#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <asio/awaitable.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>
#include <asio/thread_pool.hpp>

#include "proto/frame_stream.h"
#include "server/serve/model_set.h"
#include "server/serve/session.h"

namespace lode::serve {

/// Room for what one write sends in chunks: a full one, or several of small blobs. One a connection that is
/// sending, none one that is not; lent by its thread's pool.
struct ChunkBuffer {
  static constexpr size_t kBytes = 48u << 10;
  std::unique_ptr<std::byte[]> bytes;  ///< kBytes, or none yet
  size_t used = 0;
};

/// Buffers not in use, of one thread.
class BufferPool {
 public:
  ChunkBuffer take();
  void give(ChunkBuffer buffer);  ///< one without bytes is ignored

 private:
  std::vector<ChunkBuffer> free_;
};

/// What the connections of one thread share; it outlives them.
struct ConnectionHost {
  const ModelSet* models = nullptr;
  asio::thread_pool* readers = nullptr;  ///< threads that may wait for the disk
  BufferPool* buffers = nullptr;
};

/// A client's connection: a Session, its socket, one coroutine that reads and one that writes, both on the
/// thread of the socket. It keeps itself alive while either runs. Not thread safe.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(asio::ip::tcp::socket socket, ConnectionHost host, SessionLimits limits);
  virtual ~Connection() = default;

  void start();
  /// Starts it only to refuse it.
  void startRefusing(proto::WireError code, const std::string& why);
  void drain(const std::string& reason);
  /// Gives it up if its time has come.
  void sweep(Clock::time_point now);
  void close() noexcept { stream_.close(); }

 private:
  asio::awaitable<void> read();
  asio::awaitable<void> readFrames();
  asio::awaitable<void> write();
  asio::awaitable<void> writeFrames();
  asio::awaitable<void> gather(ChunkBuffer& buffer, bool may_wait);
  asio::awaitable<void> sleep(asio::steady_timer& until, bool& woken);
  void wakeWriter();
  void wakeReader();

  proto::FrameStream stream_;
  ConnectionHost host_;
  Session session_;
  asio::steady_timer to_write_, to_read_;  ///< never expire; cancelled when there is work again
  bool write_woken_ = false, read_woken_ = false;
  bool gone_ = false;                              ///< the client has closed, or the connection broke
  std::optional<Clock::time_point> linger_until_;  ///< all is said; the client should close before this
};

}  // namespace lode::serve
