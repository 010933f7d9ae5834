#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "client/stream/blob_cache.h"

namespace lode::stream {

constexpr uint64_t kMaxUnwrittenBytes = 16u << 20;  ///< of blobs that wait for the disk; more are not kept

/// A thread that reads from and writes to a BlobCache, so that nobody waits for a disk; reading goes first.
/// The destructor waits until all is written and joins it. Thread safe.
class CacheThread {
 public:
  /// @param wake  called on the thread, and must be quick, when there are answers to take.
  /// @throws Error kIo if the system gives no thread.
  CacheThread(BlobCache cache, std::function<void()> wake);
  ~CacheThread();
  CacheThread(const CacheThread&) = delete;
  CacheThread& operator=(const CacheThread&) = delete;

  struct Answer {
    BlobRef blob;
    std::optional<std::vector<std::byte>> bytes;  ///< none: the cache does not have it
  };

  /// Each blob gets an answer. How many may be asked for at a time is the caller's to bound.
  void find(const std::vector<BlobRef>& blobs);
  void keep(const BlobRef& blob, std::vector<std::byte> bytes);
  std::vector<Answer> takeAnswers();

 private:
  struct Unwritten {
    BlobRef blob;
    std::vector<std::byte> bytes;
  };
  void work();
  void answer(const BlobRef& blob);

  BlobCache cache_;  // of the thread
  const std::function<void()> wake_;
  std::mutex mutex_;  // of what follows
  std::condition_variable work_;
  bool stopping_ = false;
  std::deque<BlobRef> asked_;
  std::deque<Unwritten> unwritten_;
  uint64_t unwritten_bytes_ = 0;
  std::vector<Answer> answers_;
  std::thread thread_;
};

}  // namespace lode::stream
