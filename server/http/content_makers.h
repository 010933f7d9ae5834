#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/http/content_cache.h"

namespace lode::http {

/// Result of making a content.
enum class MakeResult : uint8_t {
  kDone,
  kBusy,        ///< too many contents are being made, or their memory is used up; ask again later
  kUnreadable,  ///< the system could not read the store; a later request may succeed
  kFailed,      ///< the function that makes the content threw another exception, as for a damaged store
};

struct ContentMakersOptions {
  unsigned threads = 1;
  size_t queue = 256;                   ///< largest number of contents that wait for a thread
  uint64_t memory_bytes = 256'000'000;  ///< limit of the cache
};

/// Makes contents on low-priority threads, and caches them. Concurrent requests for the same content wait for
/// one job, so that it is computed once. Thread safe.
class ContentMakers {
 public:
  using Make = std::function<std::unique_ptr<const Content>()>;
  /// Receives the content of kDone. The function runs on a maker's thread and must be quick.
  using Done = std::function<void(MakeResult, std::shared_ptr<const Content>)>;

  /// @throws Error kIo if the system cannot start a thread.
  explicit ContentMakers(ContentMakersOptions options);
  ~ContentMakers();  ///< calls join()
  ContentMakers(const ContentMakers&) = delete;
  ContentMakers& operator=(const ContentMakers&) = delete;

  /// Returns a cached content, or null.
  std::shared_ptr<const Content> find(const std::string& key);
  /// Makes a content, or waits for the job that already makes it, and calls `done`.
  /// @param make  runs on a maker's thread.
  /// @return false if the queue is full; `done` is then not called.
  bool make(const std::string& key, Make make, Done done);
  ContentCache& cache() noexcept;

  uint64_t made() const noexcept;  ///< number of contents made
  /// Drops waiting requests, so that no `done` is called any more. Waits at most a second for running
  /// functions. Those that take longer, for example because the disk is slow, end on detached threads.
  void join();

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace lode::http
