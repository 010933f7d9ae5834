#pragma once

#include <atomic>

namespace lode::ingest {

/// Grants extra threads to callers that can divide their work, up to a limit. Thread safe.
class Helpers {
 public:
  virtual ~Helpers() = default;
  /// Requests one more thread. @return true if the caller may run one more thread until it calls release().
  virtual bool take() = 0;
  virtual void release() = 0;
};

/// Grants at most a fixed number of threads at a time.
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
