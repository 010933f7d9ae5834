#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <future>
#include <utility>

namespace lode::ingest {

/// Pieces of work that are done at once, some on threads of their own, and whose results are handed on in the
/// order in which the pieces came. To be used from one thread, which is where results are handed on.
template <typename Result>
class InOrder {
 public:
  using Sink = std::function<void(Result&&)>;

  /// @param beside  how many pieces may be under way beside the caller, who does the next one itself when
  /// there are so many.
  InOrder(unsigned beside, Sink sink) : beside_(beside), sink_(std::move(sink)) {}

  /// Throws what an earlier piece has thrown, as finish() does. When a piece begins, the one `beside` + 1
  /// before it has been handed on.
  template <typename Work>
  void push(Work&& work) {
    while (!under_way_.empty() && isDone(under_way_.front())) handOnOldest();
    if (under_way_.size() < beside_) {
      under_way_.push_back(std::async(std::launch::async, std::forward<Work>(work)));
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

  void handOnOldest() {
    std::future<Result> oldest = std::move(under_way_.front());
    under_way_.pop_front();
    sink_(oldest.get());
  }

  const unsigned beside_;
  const Sink sink_;
  std::deque<std::future<Result>> under_way_;  ///< each waits for its thread when it goes
};

}  // namespace lode::ingest
