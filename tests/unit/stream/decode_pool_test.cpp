#include "client/stream/decode_pool.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <future>
#include <mutex>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace lode::stream {
namespace {

/// Collects the results of a pool.
class Results {
 public:
  void wake() {
    const std::lock_guard lock(mutex_);
    woken_.notify_one();
  }
  /// Takes results until the given number is reached.
  std::vector<core::DecodeResult> waitFor(DecodePool& pool, size_t count) {
    std::vector<core::DecodeResult> all;
    std::unique_lock lock(mutex_);
    while (all.size() < count) {
      for (core::DecodeResult& result : pool.takeResults()) all.push_back(std::move(result));
      if (all.size() < count && woken_.wait_for(lock, std::chrono::seconds(300)) == std::cv_status::timeout)
        break;
    }
    return all;
  }

 private:
  std::mutex mutex_;
  std::condition_variable woken_;
};

/// Jobs with invalid payloads, which fail fast.
std::vector<core::DecodeJob> jobs(size_t count) {
  std::vector<core::DecodeJob> made(count);
  for (core::DecodeJob& job : made) job.bytes.resize(100);
  return made;
}

TEST(DecodePool, givesAResultForEveryJobAndReportsBadOnes) {
  Results results;
  DecodePool pool(3, [&] { results.wake(); });
  pool.add(jobs(300));
  pool.add(jobs(200));
  const auto all = results.waitFor(pool, 500);
  ASSERT_EQ(all.size(), 500u);
  for (const core::DecodeResult& result : all) {
    EXPECT_EQ(result.decoded, nullptr);
    EXPECT_NE(result.failure, "");
  }
  EXPECT_TRUE(pool.takeResults().empty());
}

TEST(DecodePool, takesMoreJobsThanMayWait) {
  Results results;
  DecodePool pool(2, [&] { results.wake(); });
  pool.add(jobs(kMaxWaitingJobs + 100));
  EXPECT_EQ(results.waitFor(pool, kMaxWaitingJobs + 100).size(), kMaxWaitingJobs + 100);
}

TEST(DecodePool, queuesNoMoreJobsThanTheLimit) {
  constexpr size_t kMost = kMaxWaitingJobs + 1;  // the pool's thread has taken the first job
  std::promise<void> released;
  std::atomic<size_t> wakes{0}, added{0};
  DecodePool pool(1, [&] {
    if (wakes++ == 0) released.get_future().wait();
  });
  std::thread adder([&] {
    for (; added < 2 * kMost; ++added) pool.add(jobs(1));
  });
  while (added < kMost) std::this_thread::yield();
  for (int turn = 0; turn < 1000; ++turn) std::this_thread::yield();  // time to add more jobs
  EXPECT_EQ(added, kMost);
  released.set_value();
  adder.join();
  EXPECT_EQ(added, 2 * kMost);
}

TEST(DecodePool, dropsWaitingJobsWhenItEnds) {
  std::promise<void> first_woke, closed;
  size_t wakes = 0;
  std::thread adder;
  {
    DecodePool pool(1, [&] {
      if (++wakes > 1) return;
      first_woke.set_value();
      closed.get_future().wait();
    });
    adder = std::thread([&] {
      pool.add(jobs(kMaxWaitingJobs + 2));  // one more than fits: blocks until the pool ends
      closed.set_value();
    });
    first_woke.get_future().wait();
  }
  adder.join();
  EXPECT_EQ(wakes, 1u);
}

}  // namespace
}  // namespace lode::stream
