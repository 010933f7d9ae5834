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

namespace lode::ingest {

/// Pieces of work that are done at once, some on threads of its own, which stay until it goes, and whose
/// results are handed on in the order in which the pieces came. To be used from one thread, which is where
/// results are handed on.
template <typename Result>
class InOrder {
 public:
  using Sink = std::function<void(Result&&)>;

  /// @param beside  how many pieces may be under way beside the caller, who does the next one itself when
  /// there are so many.
  InOrder(unsigned beside, Sink sink) : beside_(beside), sink_(std::move(sink)) {}
  InOrder(const InOrder&) = delete;
  ~InOrder() {
    {
      std::lock_guard lock(mutex_);
      is_ending_ = true;
    }
    changed_.notify_all();
  }

  /// Throws what an earlier piece has thrown, as finish() does. When a piece begins, the one `beside` + 1
  /// before it has been handed on.
  template <typename Work>
  void push(Work&& work) {
    while (!under_way_.empty() && isDone(under_way_.front())) handOnOldest();
    if (under_way_.size() < beside_ && hasThreadForOneMore()) {
      start(std::packaged_task<Result()>(std::forward<Work>(work)));
      return;
    }
    Result result = work();
    finish();
    sink_(std::move(result));
  }

  /// Returns when all are handed on.
  void finish() {
    while (!under_way_.empty()) handOnOldest();
  }

 private:
  static bool isDone(const std::future<Result>& piece) {
    return piece.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }

  /// The system may give none.
  bool hasThreadForOneMore() {
    if (threads_.size() > under_way_.size()) return true;
    try {
      threads_.emplace_back([this] { work(); });
      return true;
    } catch (const std::system_error&) {
      return false;
    }
  }

  void start(std::packaged_task<Result()> piece) {
    under_way_.push_back(piece.get_future());
    {
      std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(piece));
    }
    changed_.notify_one();
  }

  void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return is_ending_ || !waiting_.empty(); });
      if (waiting_.empty()) return;
      std::packaged_task<Result()> piece = std::move(waiting_.front());
      waiting_.pop_front();
      lock.unlock();
      piece();
      piece = {};
      lock.lock();
    }
  }

  void handOnOldest() {
    std::future<Result> oldest = std::move(under_way_.front());
    under_way_.pop_front();
    sink_(oldest.get());
  }

  const unsigned beside_;
  const Sink sink_;
  std::deque<std::future<Result>> under_way_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::packaged_task<Result()>> waiting_;  ///< for a thread
  bool is_ending_ = false;
  std::vector<std::jthread> threads_;  ///< go first: they use the others
};

}  // namespace lode::ingest
