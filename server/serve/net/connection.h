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

#include "proto/frame_stream.h"
#include "server/serve/memory/memory_budget.h"
#include "server/serve/net/admission.h"
#include "server/serve/net/byte_rate.h"
#include "server/serve/net/client_connection.h"
#include "server/serve/net/wrong_tokens.h"
#include "server/serve/ops/log.h"
#include "server/serve/ops/metrics.h"
#include "server/serve/session/disk_readers.h"
#include "server/serve/session/session.h"

namespace lode::serve {

/// Buffer for one write, with one full chunk or the chunks of several small blobs. A connection borrows a
/// buffer from its thread's pool while it sends.
struct ChunkBuffer {
  /// Size of a buffer. The kernel splits a write that exceeds 64 KiB, headers included, into several
  /// segments. A buffer of this size fits in one segment, which wakes the receiver only once.
  static constexpr size_t kBytes = 60u << 10;
  std::unique_ptr<std::byte[]> bytes;  ///< kBytes long, or null
  size_t used = 0;
};

/// Unused buffers of one thread.
class BufferPool {
 public:
  ChunkBuffer take();
  void give(ChunkBuffer buffer);  ///< takes a buffer back; ignores a buffer without bytes

 private:
  std::vector<ChunkBuffer> free_;
};

class HttpFiles;

/// State that the connections of one thread share. Must outlive the connections. Only that thread uses it.
struct ConnectionHost {
  ServedSet served;
  std::shared_ptr<asio::ssl::context> tls;  ///< TLS context for new connections, or null for no TLS
  Log* log = nullptr;
  ThreadCounters* counters = nullptr;
  ByteRate* rate = nullptr;  ///< rate limit that all connections of the server share
  MemoryBudget* budget = nullptr;
  WrongTokens* wrong_tokens = nullptr;  ///< delays of answers to wrong tokens, shared by all threads
  DiskReaders* readers = nullptr;       ///< threads for reads that wait for the disk
  bool is_public = false;               ///< pages of other hosts may open WebSockets
  HttpFiles* http = nullptr;            ///< contents for HTTP, shared by all threads; null without HTTP
  BufferPool buffers;
  std::unordered_set<ClientConnection*> connections;
};

struct ConnectionLimits {
  SessionLimits session;
  Clock::duration write = proto::kWriteDeadline;  ///< longest time that a write may take
  uint64_t bytes_per_second = 0;                  ///< rate limit for blobs, or 0 for no limit
  /// Size of unsent answers above which the connection reads no further frame.
  size_t queued_answer_bytes = proto::kMaxQueuedAnswerBytes;
  bool proxy_protocol = false;           ///< expect a balancer's header at the start
  Clock::duration read = kReadDeadline;  ///< longest wait for a content of HTTP
};

/// Memory charged for an idle connection.
constexpr uint64_t kPlainConnectionBytes = 8u << 10, kTlsConnectionBytes = 80u << 10;

/// A client's connection, which consists of a Session, the stream, a reading coroutine and a writing
/// coroutine. Both coroutines run on the socket's thread and keep the connection alive. Not thread safe.
class Connection : public ClientConnection, public std::enable_shared_from_this<Connection> {
 public:
  /// @param client  the client's address, for the log.
  Connection(proto::ByteStream stream, Slot slot, MemoryAccount memory, ConnectionHost& host,
             ConnectionLimits limits, std::string client);
  ~Connection() override;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void start();
  void drain(const std::string& reason) override;
  void servedSetChanged() override;
  void sweep(Clock::time_point now) override;
  void endForMemory() override;
  uint64_t heldBytes() const noexcept override { return memory_.held(); }

 private:
  /// A chunk that a thread of DiskReaders reads. The chunk's request is parked (not chosen for sending) until
  /// the read ends.
  struct ColdRead {
    Chunk chunk;
    std::vector<std::byte> bytes;
    ReadResult result = ReadResult::kCold;  ///< kCold until the read is finished
  };

  asio::awaitable<void> read();
  asio::awaitable<bool> greet();
  void turnAway(RefusalReason refused, EndReason ended, const std::string& why);
  asio::awaitable<void> readFrames();
  bool refuseUnheard();
  asio::awaitable<void> delayAnswer();
  void releaseStorageOf(proto::Frame& frame);
  asio::awaitable<void> write();
  asio::awaitable<void> writeFrames();
  asio::awaitable<void> sleep(asio::steady_timer& until, bool& woken);
  void startWriting();
  bool isItsTurn();
  void endTurn(size_t sent_bytes);
  void gather(ChunkBuffer& buffer);
  ReadResult readChunk(const Chunk& chunk, std::span<std::byte> into);
  bool dropFinishedReads(uint32_t bytes);
  bool startFetching(const Chunk& chunk);
  void endFetching(const std::shared_ptr<ColdRead>& cold);
  void fail(const Chunk& chunk, ReadResult result);
  void noteRead(const Chunk& chunk) noexcept;
  bool linkIsSlow();
  void end(EndReason reason);
  void wakeWriter();
  void wakeReader();

  Slot slot_;
  MemoryAccount memory_;
  /// Memory of chunks being read from disk; separate from memory_, so that reads do not reduce the memory for
  /// requests.
  MemoryAccount reading_;
  ConnectionHost& host_;
  ConnectionLimits limits_;
  proto::FrameStream stream_;
  Session session_;
  std::vector<std::shared_ptr<ColdRead>> cold_;
  ByteRate rate_;
  /// Time at which the rate limits allow the next write; empty if no time is reserved.
  std::optional<Clock::time_point> turn_;
  asio::steady_timer to_write_, to_read_;  ///< timers that are cancelled to wake a coroutine
  bool write_woken_ = false, read_woken_ = false;
  bool gone_ = false;          ///< the client has closed the connection, or the connection broke
  bool holds_answer_ = false;  ///< the writer waits until delayAnswer() has ended
  bool slow_ = true;           ///< true if many unsent bytes may be waiting in the kernel
  /// Time by which the client should have closed the connection; set when everything is sent.
  std::optional<Clock::time_point> linger_until_;
  std::optional<Clock::time_point> writing_since_;  ///< start of the current write; empty between writes
  std::optional<EndReason> end_;
  std::string why_;  ///< reason of a refusal, for the log
  std::string client_;
  Clock::time_point began_ = Clock::now();
  uint64_t frames_ = 0, sent_bytes_ = 0, blobs_ = 0;  ///< totals of this connection
};

}  // namespace lode::serve
