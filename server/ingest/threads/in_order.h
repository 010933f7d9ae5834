#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "server/ingest/threads/helpers.h"

namespace lode::ingest {

/// Runs pieces of work in parallel, on helper threads and the calling thread, and passes the results to a
/// sink in the order of push(). Call all functions from one thread; the sink runs on the same thread.
template <typename Result>
class InOrder {
 public:
  using Sink = std::function<void(Result&&)>;

  /// @param helpers  must outlive this object.
  InOrder(Helpers& helpers, Sink sink) : helpers_(helpers), sink_(std::move(sink)) {}
  InOrder(const InOrder&) = delete;
  /// Waits for running pieces of work and drops the waiting pieces.
  ~InOrder() {
    {
      std::lock_guard lock(mutex_);
      is_ending_ = true;
    }
    changed_.notify_all();
  }

  /// Queues a piece of work. Then works on the calling thread while more than 1 + kWaitingPerThread pieces
  /// per helper have not reached the sink. Without helpers, push() therefore returns only after the sink has
  /// received the result. Rethrows exceptions of earlier pieces, like finish().
  template <typename Work>
  void push(Work&& work) {
    std::packaged_task<Result()> piece(std::forward<Work>(work));
    under_way_.push_back(piece.get_future());
    {
      std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(piece));
    }
    passOnUntil([this] { return under_way_.size() <= (1 + kWaitingPerThread) * callHelper(); });
  }

  /// Returns when the sink has received all results.
  void finish() {
    passOnUntil([this] { return under_way_.empty() || (callHelper(), false); });
  }

  static constexpr size_t kWaitingPerThread = 2;

 private:
  static bool isDone(const std::future<Result>& piece) {
    return piece.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }

  /// Passes finished results to the sink until isEnough() returns true. Meanwhile runs a waiting piece, or if
  /// no piece is waiting, blocks until the oldest piece is finished.
  template <typename IsEnough>
  void passOnUntil(IsEnough&& isEnough) {
    while (true) {
      while (!under_way_.empty() && isDone(under_way_.front())) passOnOldest();
      if (isEnough()) return;
      if (!runWaiting()) passOnOldest();
    }
  }

  void passOnOldest() {
    std::future<Result> oldest = std::move(under_way_.front());
    under_way_.pop_front();
    sink_(oldest.get());
  }

  bool runWaiting() {
    std::unique_lock lock(mutex_);
    if (waiting_.empty()) return false;
    std::packaged_task<Result()> piece = takeWaiting();
    lock.unlock();
    piece();
    return true;
  }

  /// Wakes or starts a helper if a piece is waiting. @return number of helpers called or working.
  size_t callHelper() {
    std::unique_lock lock(mutex_);
    if (waiting_.empty() || !helpers_.take()) return called_ + working_;
    if (threads_.size() == called_ + working_ && !startThread()) {
      helpers_.release();
      return called_ + working_;
    }
    const size_t at_work = ++called_ + working_;
    lock.unlock();
    changed_.notify_one();
    return at_work;
  }

  /// Returns false if the system cannot start a thread.
  bool startThread() {
    try {
      threads_.emplace_back([this] { help(); });
      return true;
    } catch (const std::system_error&) {
      return false;
    }
  }

  void help() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return is_ending_ || called_ > 0; });
      if (called_ == 0) return;
      --called_;
      ++working_;
      while (!waiting_.empty() && !is_ending_) {
        std::packaged_task<Result()> piece = takeWaiting();
        lock.unlock();
        piece();
        piece = {};
        lock.lock();
      }
      --working_;
      helpers_.release();
    }
  }

  std::packaged_task<Result()> takeWaiting() {
    std::packaged_task<Result()> piece = std::move(waiting_.front());
    waiting_.pop_front();
    return piece;
  }

  Helpers& helpers_;
  const Sink sink_;
  std::deque<std::future<Result>> under_way_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::packaged_task<Result()>> waiting_;  ///< pieces that no thread has taken
  size_t called_ = 0, working_ = 0;  ///< helpers that are called but not yet working, and working
  bool is_ending_ = false;
  /// Must be the last member, so that the threads are joined before other members are destroyed.
  std::vector<std::jthread> threads_;
};

}  // namespace lode::ingest
