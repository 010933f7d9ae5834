#pragma once

#include <atomic>

namespace lode::ingest {

/// Threads beside the caller's that may run a part of its work for a while. Thread safe.
class Helpers {
 public:
  virtual ~Helpers() = default;
  /// @return true if one is the caller's now, who starts a thread in its name, until giveBack().
  virtual bool take() = 0;
  virtual void giveBack() = 0;
};

/// As many as were asked for, for one piece of work after another.
class FixedHelpers final : public Helpers {
 public:
  explicit FixedHelpers(unsigned count) : left_(count) {}
  bool take() override {
    unsigned left = left_;
    while (left > 0 && !left_.compare_exchange_weak(left, left - 1)) continue;
    return left > 0;
  }
  void giveBack() override { ++left_; }

 private:
  std::atomic<unsigned> left_;
};

}  // namespace lode::ingest
