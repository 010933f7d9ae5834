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

/// Pieces of work that are done at once, by helpers as they are to be had and by the caller, and whose
/// results are handed on in the order in which the pieces came. To be used from one thread, which is where
/// results are handed on.
template <typename Result>
class InOrder {
 public:
  using Sink = std::function<void(Result&&)>;

  /// @param helpers  outlive this.
  InOrder(Helpers& helpers, Sink sink) : helpers_(helpers), sink_(std::move(sink)) {}
  InOrder(const InOrder&) = delete;
  /// Waits for pieces that have begun; others are dropped.
  ~InOrder() {
    {
      std::lock_guard lock(mutex_);
      is_ending_ = true;
    }
    changed_.notify_all();
  }

  /// Throws what an earlier piece has thrown, as finish() does. Where no helper works the piece is done, and
  /// handed on, when this returns; behind each that does kWaitingForEach wait, so that neither it nor the
  /// caller has to.
  template <typename Work>
  void push(Work&& work) {
    std::packaged_task<Result()> piece(std::forward<Work>(work));
    under_way_.push_back(piece.get_future());
    {
      std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(piece));
    }
    handOnUntil([this] { return under_way_.size() <= (1 + kWaitingForEach) * callHelper(); });
  }

  /// Returns when all are handed on.
  void finish() {
    handOnUntil([this] { return under_way_.empty() || (callHelper(), false); });
  }

  static constexpr size_t kWaitingForEach = 2;

 private:
  static bool isDone(const std::future<Result>& piece) {
    return piece.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }

  /// Hands on what is done; does pieces that wait, or waits for the oldest, until `isEnough()`.
  template <typename IsEnough>
  void handOnUntil(IsEnough&& isEnough) {
    while (true) {
      while (!under_way_.empty() && isDone(under_way_.front())) handOnOldest();
      if (isEnough()) return;
      if (!doOneThatWaits()) handOnOldest();
    }
  }

  void handOnOldest() {
    std::future<Result> oldest = std::move(under_way_.front());
    under_way_.pop_front();
    sink_(oldest.get());
  }

  bool doOneThatWaits() {
    std::unique_lock lock(mutex_);
    if (waiting_.empty()) return false;
    std::packaged_task<Result()> piece = takeWaiting();
    lock.unlock();
    piece();
    return true;
  }

  /// Where a piece waits for one. @return how many work.
  size_t callHelper() {
    std::unique_lock lock(mutex_);
    if (waiting_.empty() || !helpers_.take()) return called_ + working_;
    if (threads_.size() == called_ + working_ && !startThread()) {
      helpers_.giveBack();
      return called_ + working_;
    }
    const size_t at_work = ++called_ + working_;
    lock.unlock();
    changed_.notify_one();
    return at_work;
  }

  /// The system may give none.
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
      helpers_.giveBack();
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
  std::deque<std::packaged_task<Result()>> waiting_;  ///< for the caller or a helper
  size_t called_ = 0, working_ = 0;                   ///< helpers
  bool is_ending_ = false;
  std::vector<std::jthread>
      threads_;  ///< the helpers'; stay until this goes, and go first: they use the others
};

}  // namespace lode::ingest
