#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "server/serve/session/blob_reader.h"

namespace lode::serve {

constexpr std::chrono::milliseconds kReadDeadline{10'000};  ///< time that a read may take

struct DiskReaderOptions {
  using TimePoint = std::chrono::steady_clock::time_point;
  size_t threads = 6;          ///< threads that read, apart from blocked threads
  size_t max_threads = 256;    ///< limit for all threads; at this limit, no thread replaces a blocked thread
  size_t reads_per_store = 4;  ///< largest number of simultaneous reads of a store; further reads wait
  size_t many_blocked = 16;    ///< number of blocked threads above which a store has one read at a time
  /// Duration of a read after which its thread counts as blocked, and another thread replaces it.
  std::chrono::nanoseconds replace_after = std::chrono::milliseconds(500);
  std::chrono::nanoseconds deadline = kReadDeadline;  ///< duration after which a read is late
  std::function<TimePoint()> clock = std::chrono::steady_clock::now;
};

/// Threads for reads that wait for the disk. Stores take turns. If a read blocks its thread for long, another
/// thread replaces the blocked thread. For the caller, a late read ends with kUnreadable. While all reads of
/// a store are late, its other reads end with kUnreadable at once. A store with hanging storage therefore
/// blocks at most reads_per_store threads, and delays other stores by at most replace_after. Thread safe.
class DiskReaders {
 public:
  using TimePoint = DiskReaderOptions::TimePoint;
  /// Receives a read's result and, for kDone, its bytes, which the function may move. Any thread can call the
  /// function, also read() itself. If the function throws std::bad_alloc, the next tick() calls it again.
  using Done = std::function<void(ReadResult, std::vector<std::byte>& bytes)>;

  /// @throws Error kIo if the system cannot start the threads.
  explicit DiskReaders(DiskReaderOptions options = {});
  ~DiskReaders();  ///< calls join()
  DiskReaders(const DiskReaders&) = delete;
  DiskReaders& operator=(const DiskReaders&) = delete;

  /// Reads a range of a blob and calls `done`. The caller bounds the number of its reads.
  /// @throws std::bad_alloc before the read is queued.
  void read(std::shared_ptr<const BlobReader> blobs, const BlobRange& range, Done done);
  /// Runs a task that reads no store, such as returning memory to the system.
  void post(std::function<void()> task);
  /// Ends late reads and replaces blocked threads. Call tick() several times per replace_after.
  void tick();
  /// Ends waiting reads with kUnreadable. Then waits at most kJoinPatience for the running reads that are not
  /// late. Late reads end later on detached threads, which own a share of all memory that they use.
  void join();

  static constexpr std::chrono::seconds kJoinPatience{1};

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace lode::serve
