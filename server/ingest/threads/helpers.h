#pragma once

#include <atomic>

namespace lode::ingest {

/// Limits the number of threads that callers use for part of their work. Thread safe.
class Helpers {
 public:
  virtual ~Helpers() = default;
  /// Requests one more thread. @return true if the caller can use the thread until it calls release().
  virtual bool take() = 0;
  virtual void release() = 0;
};

/// Helpers with a fixed number of threads.
class FixedHelpers final : public Helpers {
 public:
  explicit FixedHelpers(unsigned count) : left_(count) {}
  bool take() override {
    unsigned left = left_;
    while (left > 0 && !left_.compare_exchange_weak(left, left - 1)) continue;
    return left > 0;
  }
  void release() override { ++left_; }

 private:
  std::atomic<unsigned> left_;
};

}  // namespace lode::ingest
