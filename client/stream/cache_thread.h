#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "client/core/cache/cache_queries.h"
#include "client/stream/blob_cache.h"

namespace lode::stream {

/// Limit for the total size of the blobs that wait to be written. Further blobs are not cached.
constexpr uint64_t kMaxUnwrittenBytes = 16u << 20;
/// Largest number of blobs that wait to be looked up. It is larger than the number of one engine's queries,
/// because an engine forgets its queries when the server replaces the model.
constexpr size_t kMaxWaitingLookups = 4 * core::kMaxCacheQueries;

/// Runs a BlobCache on a thread of its own, so that callers never wait for the disk. Waiting reads are served
/// before waiting writes. The destructor finishes all writes and joins the thread. Thread safe.
class CacheThread {
 public:
  /// @param wake  function that is called when answers can be taken, by the cache's thread or in find(); must
  ///              return quickly.
  /// @throws Error kIo if no thread can be started.
  CacheThread(BlobCache cache, std::function<void()> wake);
  ~CacheThread();
  CacheThread(const CacheThread&) = delete;
  CacheThread& operator=(const CacheThread&) = delete;

  struct Answer {
    BlobRef blob;
    std::optional<std::vector<std::byte>> bytes;  ///< bytes of the blob; nothing for a miss
  };

  /// Looks up blobs; takeAnswers() returns an answer for each blob. If kMaxWaitingLookups blobs wait already,
  /// each further blob counts as a miss at once.
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

  BlobCache cache_;  // only the thread uses the cache
  const std::function<void()> wake_;
  std::mutex mutex_;  // guards the members below, except thread_
  std::condition_variable work_;
  bool stopping_ = false;
  std::deque<BlobRef> asked_;
  std::deque<Unwritten> unwritten_;
  uint64_t unwritten_bytes_ = 0;
  std::vector<Answer> answers_;
  std::thread thread_;
};

}  // namespace lode::stream
