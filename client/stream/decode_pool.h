#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "client/core/engine.h"
#include "common/bounded_queue.h"

namespace lode::stream {

constexpr unsigned kMaxDecodeThreads = 256;

/// Returns the default number of decode threads: the number of cores minus two, but at least one.
unsigned defaultDecodeThreads() noexcept;

/// A pool of low-priority threads that decode blobs. The destructor drops waiting jobs and joins the threads.
/// Thread safe.
class DecodePool {
 public:
  /// @param threads  number of threads; 0: defaultDecodeThreads().
  /// @param wake     function that a pool thread calls when results can be taken; must return quickly.
  /// @throws Error kUsage above kMaxDecodeThreads, kIo if a thread cannot be started.
  DecodePool(unsigned threads, std::function<void()> wake);
  ~DecodePool();
  DecodePool(const DecodePool&) = delete;
  DecodePool& operator=(const DecodePool&) = delete;

  /// Queues jobs. Blocks only while kMaxWaitingJobs jobs already wait.
  void add(std::vector<core::DecodeJob> jobs);
  std::vector<core::DecodeResult> takeResults();

 private:
  void work();
  void stop();

  const std::function<void()> wake_;
  BoundedQueue<core::DecodeJob> jobs_;
  std::atomic<bool> stopping_{false};
  std::mutex mutex_;
  std::vector<core::DecodeResult> results_;
  std::vector<std::thread> threads_;
};

constexpr size_t kMaxWaitingJobs = 4096;

}  // namespace lode::stream
