#include "server/serve/session/disk_readers.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <climits>
#include <condition_variable>
#include <future>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/support/scarce_threads.h"
#include "tests/unit/serve/small_store.h"

namespace lode::serve {
namespace {

using namespace std::chrono_literals;

constexpr uint32_t kBlob = 2;

/// Storage that hangs for selected stores until the test lets it answer.
class Storage {
 public:
  void hang(const std::string& store) {
    change([&] { hanging_.insert(store); });
  }
  void answer() {
    change([&] { hanging_.clear(); });
  }
  /// Waits until `count` reads hang.
  void awaitHanging(size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return hangs_ == count; });
  }
  std::function<std::optional<size_t>(int, uint64_t, std::span<std::byte>)> readerOf(
      const std::string& store) {
    return [this, store](int file, uint64_t offset, std::span<std::byte> into) {
      waitFor(store);
      return readAt(file, offset, into);
    };
  }

 private:
  template <typename Action>
  void change(Action action) {
    const std::lock_guard lock(mutex_);
    action();
    changed_.notify_all();
  }
  void waitFor(const std::string& store) {
    std::unique_lock lock(mutex_);
    if (!hanging_.contains(store)) return;
    ++hangs_;
    changed_.notify_all();
    changed_.wait(lock, [&] { return !hanging_.contains(store); });
    --hangs_;
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::set<std::string> hanging_;
  size_t hangs_ = 0;
};

class DiskReadersTest : public testing::Test {
 protected:
  struct Read {
    ReadResult result;
    std::vector<std::byte> bytes;
  };

  ~DiskReadersTest() override {
    storage_.answer();
    if (readers_) readers_->join();
    storage_.awaitHanging(0);
  }

  void start(DiskReaderOptions options = {}) {
    options.clock = [this] { return DiskReaders::TimePoint(std::chrono::seconds(now_s_)); };
    readers_.emplace(std::move(options));
  }
  std::shared_ptr<const BlobReader> store(const std::string& name) {
    auto& store = stores_[name];
    if (store) return store;
    const auto path = folder_.path() / (name + ".lode");
    test::writeSmallStore(path);
    store = std::make_shared<const BlobReader>(store::Reader(path),
                                               BlobReaderOptions{.read = storage_.readerOf(name)});
    return store;
  }
  std::future<Read> read(const std::string& name) {
    const auto promise = std::make_shared<std::promise<Read>>();
    readers_->read(store(name), {kBlob, 0, 100}, [promise](ReadResult result, std::vector<std::byte>& bytes) {
      promise->set_value({result, std::move(bytes)});
    });
    return promise->get_future();
  }
  static bool hasEnded(const std::future<Read>& read) {
    return read.wait_for(0s) == std::future_status::ready;
  }
  void passDeadline() {
    now_s_ += 10;
    readers_->tick();
  }

  test::WorkFolder folder_;
  Storage storage_;
  std::atomic<int> now_s_{0};
  std::map<std::string, std::shared_ptr<const BlobReader>> stores_;
  std::optional<DiskReaders> readers_;
};

TEST_F(DiskReadersTest, aReadGivesTheBytesOfItsRange) {
  start();
  const Read done = read("a").get();
  EXPECT_EQ(done.result, ReadResult::kDone);
  const std::vector<std::byte> blob = store("a")->store().readBlob(kBlob);
  EXPECT_EQ(done.bytes, std::vector(blob.begin(), blob.begin() + 100));
}

TEST_F(DiskReadersTest, aReadThatHangsEndsAtItsDeadlineAndNotBefore) {
  start();
  storage_.hang("a");
  auto hung = read("a");
  storage_.awaitHanging(1);
  now_s_ = 9;
  readers_->tick();
  EXPECT_FALSE(hasEnded(hung));
  now_s_ = 10;
  readers_->tick();
  ASSERT_TRUE(hasEnded(hung));
  const Read ended = hung.get();
  EXPECT_EQ(ended.result, ReadResult::kUnreadable);
  EXPECT_TRUE(ended.bytes.empty());
}

TEST_F(DiskReadersTest, tickDeliversAgainWhenMemoryRanOutDuringADelivery) {
  start();
  std::atomic<int> calls{0};
  std::promise<size_t> delivered;
  std::atomic<bool> failed{false};
  readers_->read(store("a"), {kBlob, 0, 100}, [&](ReadResult, std::vector<std::byte>& bytes) {
    if (++calls <= 2) {
      failed = true;
      failed.notify_all();
      throw std::bad_alloc();
    }
    delivered.set_value(bytes.size());
  });
  failed.wait(false);
  auto size = delivered.get_future();
  while (size.wait_for(0s) != std::future_status::ready) readers_->tick();
  EXPECT_EQ(size.get(), 100u);
  EXPECT_EQ(calls, 3);
}

TEST_F(DiskReadersTest, aStoreThatHangsDelaysNoOtherStoreBeforeItsDeadline) {
  start();
  storage_.hang("a");
  std::vector<std::future<Read>> hung;
  for (int i = 0; i < 20; ++i) hung.push_back(read("a"));
  storage_.awaitHanging(4);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(read("b").get().result, ReadResult::kDone);
  for (const auto& one : hung) EXPECT_FALSE(hasEnded(one));
}

TEST_F(DiskReadersTest, replaceTheThreadsOfHangingStores) {
  start();
  const std::array names{"a", "b", "c", "d", "e", "f", "g", "h"};
  size_t hanging = 0;
  std::vector<std::future<Read>> hung;
  for (const char* name : names) {
    storage_.hang(name);
    for (int i = 0; i < 10; ++i) hung.push_back(read(name));
    hanging += hanging > DiskReaderOptions().many_blocked ? 1 : DiskReaderOptions().reads_per_store;
    storage_.awaitHanging(hanging);
    now_s_ = now_s_ + 1;  // less than the deadline in total
    readers_->tick();
    EXPECT_EQ(read("z").get().result, ReadResult::kDone) << name;
  }
  for (const auto& one : hung) EXPECT_FALSE(hasEnded(one));
  passDeadline();
  for (auto& one : hung) {
    ASSERT_TRUE(hasEnded(one));
    EXPECT_EQ(one.get().result, ReadResult::kUnreadable);
  }
}

TEST_F(DiskReadersTest, endOtherReadsOfAHangingStoreAtOnce) {
  start();
  storage_.hang("a");
  std::vector<std::future<Read>> waiting;
  for (int i = 0; i < 20; ++i) waiting.push_back(read("a"));
  storage_.awaitHanging(4);
  passDeadline();
  for (auto& one : waiting) {
    ASSERT_TRUE(hasEnded(one));
    EXPECT_EQ(one.get().result, ReadResult::kUnreadable);
  }
  auto later = read("a");
  ASSERT_TRUE(hasEnded(later));
  EXPECT_EQ(later.get().result, ReadResult::kUnreadable);
}

TEST_F(DiskReadersTest, aStoreIsReadAgainWhenItsStorageAnswers) {
  start();
  for (int time = 0; time < 5; ++time) {
    storage_.hang("a");
    std::vector<std::future<Read>> hung;
    for (int i = 0; i < 4; ++i) hung.push_back(read("a"));
    storage_.awaitHanging(4);
    passDeadline();
    for (auto& one : hung) EXPECT_EQ(one.get().result, ReadResult::kUnreadable);
    storage_.answer();
    storage_.awaitHanging(0);
    while (read("a").get().result != ReadResult::kDone) std::this_thread::yield();
  }
}

TEST_F(DiskReadersTest, limitTheNumberOfHangingThreads) {
  start({.threads = 2, .max_threads = 4, .reads_per_store = 2});
  const std::array names{"a", "b"};
  std::vector<std::future<Read>> hung;
  for (const char* name : names) storage_.hang(name);
  for (size_t i = 0; i < names.size(); ++i) {
    hung.push_back(read(names[i]));
    hung.push_back(read(names[i]));
    storage_.awaitHanging(2 * (i + 1));
    passDeadline();
  }
  auto waiting = read("z");
  passDeadline();
  EXPECT_FALSE(hasEnded(waiting)) << "no thread is left";
  storage_.answer();
  EXPECT_EQ(waiting.get().result, ReadResult::kDone);
}

TEST_F(DiskReadersTest, aStoreHasOneReadAtATimeWhileManyThreadsAreBlocked) {
  start({.threads = 6, .reads_per_store = 4, .many_blocked = 3});
  storage_.hang("a");
  storage_.hang("b");
  std::vector<std::future<Read>> hung;
  for (int i = 0; i < 4; ++i) hung.push_back(read("a"));
  storage_.awaitHanging(4);
  ++now_s_;
  readers_->tick();
  for (int i = 0; i < 4; ++i) hung.push_back(read("b"));
  storage_.awaitHanging(5);
  passDeadline();
  for (auto& one : hung) EXPECT_EQ(one.get().result, ReadResult::kUnreadable);
  EXPECT_EQ(read("z").get().result, ReadResult::kDone);
}

TEST_F(DiskReadersTest, storesTakeTurnsHoweverManyReadsOneHas) {
  start({.threads = 1, .reads_per_store = 1});
  storage_.hang("gate");
  auto gate = read("gate");
  storage_.awaitHanging(1);
  std::vector<std::future<Read>> many;
  for (int i = 0; i < 50; ++i) many.push_back(read("a"));
  auto one = read("b");
  std::promise<size_t> ended_before;
  readers_->read(store("b"), {kBlob, 0, 100}, [&](ReadResult, const std::vector<std::byte>&) {
    ended_before.set_value(static_cast<size_t>(std::ranges::count_if(many, hasEnded)));
  });
  storage_.answer();
  EXPECT_LE(ended_before.get_future().get(), 3u);
  one.get();
  for (auto& each : many) EXPECT_EQ(each.get().result, ReadResult::kDone);
}

TEST_F(DiskReadersTest, joinWithoutWaitingForLateReads) {
  start();
  storage_.hang("a");
  auto first = read("a"), second = read("a");
  storage_.awaitHanging(2);
  passDeadline();
  EXPECT_TRUE(hasEnded(first) && hasEnded(second));
  readers_->join();
  auto after = read("b");
  ASSERT_TRUE(hasEnded(after));
  EXPECT_EQ(after.get().result, ReadResult::kUnreadable);
}

TEST_F(DiskReadersTest, aTaskRunsBesideTheReads) {
  start({.threads = 1});
  std::promise<void> ran;
  readers_->post([&] { ran.set_value(); });
  EXPECT_EQ(ran.get_future().wait_for(std::chrono::seconds(30)), std::future_status::ready);
}

TEST(DiskReaders, failAndEndWhereTheSystemDoesNotGiveAllThreads) {
  for (const int threads : {0, 1, 2, 5}) {
    lode::test::threads_left = threads;
    EXPECT_THROW(DiskReaders(), Error) << threads;
  }
  lode::test::threads_left = INT_MAX;
}

}  // namespace
}  // namespace lode::serve
