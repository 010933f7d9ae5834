#pragma once

#include <deque>
#include <functional>
#include <future>
#include <utility>

namespace lode::ingest {

/// Pieces of work that are done at once, each on a thread of its own, and whose results are handed on in the
/// order in which the pieces came. To be used from one thread, which is where results are handed on.
template <typename Result>
class InOrder {
 public:
  using Sink = std::function<void(Result&&)>;

  /// @param at_once  how many pieces may be under way beside the caller; with none, push() does all itself.
  InOrder(unsigned at_once, Sink sink) : at_once_(at_once), sink_(std::move(sink)) {}

  /// Throws what an earlier piece has thrown, as finish() does. When it returns, the piece `at_once` before
  /// this one has been handed on.
  template <typename Work>
  void push(Work&& work) {
    if (at_once_ == 0) return sink_(work());
    if (under_way_.size() == at_once_) handOnOldest();
    under_way_.push_back(std::async(std::launch::async, std::forward<Work>(work)));
  }

  /// Returns when all are handed on.
  void finish() {
    while (!under_way_.empty()) handOnOldest();
  }

 private:
  void handOnOldest() {
    std::future<Result> oldest = std::move(under_way_.front());
    under_way_.pop_front();
    sink_(oldest.get());
  }

  const unsigned at_once_;
  const Sink sink_;
  std::deque<std::future<Result>> under_way_;  ///< each waits for its thread when it goes
};

}  // namespace lode::ingest
