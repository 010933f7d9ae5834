#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <unordered_set>
#include <vector>

#include <asio/awaitable.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>
#include <asio/thread_pool.hpp>

#include "proto/frame_stream.h"
#include "server/serve/memory/memory_budget.h"
#include "server/serve/net/admission.h"
#include "server/serve/net/byte_rate.h"
#include "server/serve/ops/log.h"
#include "server/serve/ops/metrics.h"
#include "server/serve/session/blob_reader.h"
#include "server/serve/session/request_memory.h"
#include "server/serve/session/served_set.h"
#include "server/serve/session/session.h"

namespace lode::serve {

/// Room for what one write sends in chunks: a full one, or several of small blobs. One a connection that is
/// sending, none one that is not; lent by its thread's pool.
struct ChunkBuffer {
  /// So much goes through the kernel as one (it parts what exceeds 64 KiB with its headers) and wakes a
  /// receiver once.
  static constexpr size_t kBytes = 60u << 10;
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

class Connection;

/// What the connections of one thread share; it outlives them. Touched on that thread only.
struct ConnectionHost {
  ServedSet served;
  std::shared_ptr<asio::ssl::context> tls;  ///< of new connections; none: they are plain
  Log* log = nullptr;
  ThreadCounters* counters = nullptr;
  ByteRate* rate = nullptr;  ///< of all connections of the server
  MemoryBudget* budget = nullptr;
  asio::thread_pool* readers = nullptr;  ///< threads that may wait for the disk
  BufferPool buffers;
  RequestMemory requests;
  std::unordered_set<Connection*> connections;
};

struct ConnectionLimits {
  SessionLimits session;
  Clock::duration write = proto::kWriteDeadline;              ///< for a write that the client does not take
  uint64_t bytes_per_second = 0;                              ///< of blobs; 0: no limit
  size_t queued_answer_bytes = proto::kMaxQueuedAnswerBytes;  ///< above it nothing more is read
  bool proxy_protocol = false;                                ///< a balancer says first who the client is
};

/// What a connection is taken to cost that does nothing.
constexpr uint64_t kPlainConnectionBytes = 8u << 10, kTlsConnectionBytes = 80u << 10;

/// A client's connection: a Session, its stream, one coroutine that reads and one that writes, both on the
/// thread of the socket. It keeps itself alive while either runs. Not thread safe.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  /// @param client  its address, for the log.
  Connection(proto::ByteStream stream, Place place, MemoryAccount memory, ConnectionHost& host,
             ConnectionLimits limits, std::string client);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void start();
  void drain(const std::string& reason);
  void servedSetChanged();
  /// Gives it up if its time has come.
  void sweep(Clock::time_point now);
  /// Gives it up for the memory that it holds.
  void giveUpForMemory();
  uint64_t heldBytes() const noexcept { return memory_.held(); }

 private:
  /// A chunk that the disk is asked for; its request is parked meanwhile.
  struct ColdRead {
    Chunk chunk;
    std::vector<std::byte> bytes;
    ReadResult result = ReadResult::kCold;  ///< kCold: not there yet
  };

  asio::awaitable<void> read();
  asio::awaitable<bool> greet();
  void turnAway(RefusalReason refused, EndReason ended, const std::string& why);
  asio::awaitable<void> readFrames();
  void releaseStorageOf(proto::Frame& frame);
  asio::awaitable<void> write();
  asio::awaitable<void> writeFrames();
  asio::awaitable<void> fetch(std::shared_ptr<ColdRead> cold, std::shared_ptr<const BlobReader> blobs);
  asio::awaitable<void> sleep(asio::steady_timer& until, bool& woken);
  void startWriting();
  bool isItsTurn();
  void endTurn(size_t sent_bytes);
  void gather(ChunkBuffer& buffer);
  ReadResult readChunk(const Chunk& chunk, std::span<std::byte> into);
  bool startFetching(const Chunk& chunk);
  void fail(const Chunk& chunk, ReadResult result);
  void noteRead(const Chunk& chunk) noexcept;
  bool linkIsSlow();
  void end(EndReason reason);
  void wakeWriter();
  void wakeReader();

  Place place_;
  MemoryAccount memory_;
  MemoryAccount
      reading_;  ///< what the disk is asked for: no greed of the client's, who may request and ask on
  ConnectionHost& host_;
  ConnectionLimits limits_;
  proto::FrameStream stream_;
  Session session_;
  std::vector<std::shared_ptr<ColdRead>> cold_;
  ByteRate rate_;
  std::optional<Clock::time_point> turn_;  ///< when it may send as much as a slow link is given
  asio::steady_timer to_write_, to_read_;  ///< cancelled when there is work again
  bool write_woken_ = false, read_woken_ = false;
  bool gone_ = false;                               ///< the client has closed, or the connection broke
  bool slow_ = true;                                ///< more than a little waits in the kernel, or may
  std::optional<Clock::time_point> linger_until_;   ///< all is said; the client should close before this
  std::optional<Clock::time_point> writing_since_;  ///< something is to be written
  std::optional<EndReason> end_;
  std::string why_;  ///< it was turned away before the first frame, or its session has refused it
  std::string client_;
  Clock::time_point began_ = Clock::now();
  uint64_t frames_ = 0, sent_bytes_ = 0, blobs_ = 0;  ///< of the connection so far
};

}  // namespace lode::serve
