#pragma once

#include <cstddef>
#include <memory>
#include <thread>
#include <vector>

#include <asio/thread_pool.hpp>

namespace lode::serve {

/// Threads that may wait for the disk.
class ReaderThreads {
 public:
  /// @throws Error kIo if the system does not give so many.
  explicit ReaderThreads(size_t count);
  ~ReaderThreads() { join(); }
  ReaderThreads(const ReaderThreads&) = delete;
  ReaderThreads& operator=(const ReaderThreads&) = delete;

  asio::thread_pool& pool() noexcept { return *pool_; }
  /// Waits until all that was given to the pool is done.
  void join();

 private:
  std::unique_ptr<asio::thread_pool> pool_;  ///< of one thread: if asio gets less than all, it waits for ever
  std::vector<std::jthread> others_;         ///< run the same pool
};

}  // namespace lode::serve
