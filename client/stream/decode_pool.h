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

/// How many threads decode where nobody has said it: as many as there are cores but two, at least one.
unsigned defaultDecodeThreads() noexcept;

/// Threads of low priority that decode payloads. The destructor drops what waits and joins them. Thread safe.
class DecodePool {
 public:
  /// @param threads  0: defaultDecodeThreads().
  /// @param wake     called on a pool's thread, and must be quick, when there are results to take.
  /// @throws Error kUsage above kMaxDecodeThreads, kIo if the system does not give so many.
  DecodePool(unsigned threads, std::function<void()> wake);
  ~DecodePool();
  DecodePool(const DecodePool&) = delete;
  DecodePool& operator=(const DecodePool&) = delete;

  /// Waits only if more than kMaxWaitingJobs wait already.
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
