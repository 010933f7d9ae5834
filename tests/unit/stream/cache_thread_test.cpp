#include "client/stream/cache_thread.h"

#include <atomic>
#include <future>
#include <map>
#include <memory>

#include <gtest/gtest.h>

#include "tests/support/work_folder.h"

namespace lode::stream {
namespace {

using namespace std::chrono_literals;

std::vector<std::byte> bytesOf(uint32_t number) { return {3000, static_cast<std::byte>(number)}; }
BlobRef refOf(uint32_t number) { return {number, 3000, digestOf(bytesOf(number))}; }

TEST(CacheThreadTest, writesAllQueuedBlobsBeforeItEnds) {
  const test::WorkFolder folder;
  {
    CacheThread thread(BlobCache(folder / "cache", 1u << 20), [] {});
    for (uint32_t number = 1; number <= 20; ++number) thread.keep(refOf(number), bytesOf(number));
  }
  BlobCache cache(folder / "cache", 1u << 20);
  for (uint32_t number = 1; number <= 20; ++number)
    EXPECT_EQ(cache.find(refOf(number)), bytesOf(number)) << number;
}

TEST(CacheThreadTest, dropsBlobsAboveTheLimitOfUnwrittenBytes) {
  const test::WorkFolder folder;
  const std::vector<std::byte> bytes(kMaxUnwrittenBytes + 1);
  const BlobRef blob{1, static_cast<uint32_t>(bytes.size()), digestOf(bytes)};
  CacheThread(BlobCache(folder / "cache", 1u << 30), [] {}).keep(blob, bytes);
  EXPECT_FALSE(BlobCache(folder / "cache", 1u << 30).find(blob));
}

/// A cache whose thread waits after its first answer until release().
class ABusyCacheThread : public testing::Test {
 protected:
  ABusyCacheThread() {
    thread_->find({refOf(0)});
    answered_.get_future().wait();
  }
  ~ABusyCacheThread() override { release(); }
  /// Lets the thread finish its work and end.
  void release() {
    if (thread_) released_.set_value();
    thread_.reset();
  }

  const test::WorkFolder folder_;
  std::promise<void> answered_, released_;
  std::atomic<unsigned> wakes_{0};
  std::unique_ptr<CacheThread> thread_ =
      std::make_unique<CacheThread>(BlobCache(folder_ / "cache", 1u << 30), [this] {
        if (wakes_++ != 0) return;
        answered_.set_value();
        released_.get_future().wait();
      });
};

TEST_F(ABusyCacheThread, keepsNoMoreUnwrittenBytesThanTheLimit) {
  constexpr uint32_t kBlobBytes = 1u << 20, kBlobs = kMaxUnwrittenBytes / kBlobBytes + 3;
  std::vector<BlobRef> blobs;
  for (uint32_t number = 0; number < kBlobs; ++number) {
    const std::vector<std::byte> bytes(kBlobBytes, static_cast<std::byte>(number));
    blobs.push_back({number, kBlobBytes, digestOf(bytes)});
    thread_->keep(blobs.back(), bytes);
  }
  release();
  BlobCache cache(folder_ / "cache", 1u << 30);
  for (uint32_t number = 0; number < kBlobs; ++number)
    EXPECT_EQ(cache.find(blobs[number]).has_value(), number < kMaxUnwrittenBytes / kBlobBytes) << number;
}

TEST_F(ABusyCacheThread, countsBlobsAboveTheLimitOfLookupsAsMisses) {
  thread_->takeAnswers();
  thread_->find(std::vector<BlobRef>(kMaxWaitingLookups, refOf(1)));
  EXPECT_EQ(thread_->takeAnswers().size(), 0u);
  thread_->find({refOf(2), refOf(3)});
  EXPECT_EQ(wakes_, 2u) << "the caller learns of the misses";
  const std::vector<CacheThread::Answer> answers = thread_->takeAnswers();
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_EQ(answers[0].blob, refOf(2));
  EXPECT_EQ(answers[1].blob, refOf(3));
  EXPECT_FALSE(answers[0].bytes || answers[1].bytes);
}

TEST(CacheThreadTest, answersEachQuestionOnce) {
  const test::WorkFolder folder;
  BlobCache(folder / "cache", 1u << 20).keep(refOf(1), bytesOf(1));
  std::mutex mutex;
  std::condition_variable woken;
  unsigned wakes = 0;
  CacheThread thread(BlobCache(folder / "cache", 1u << 20), [&] {
    const std::lock_guard lock(mutex);
    ++wakes;
    woken.notify_one();
  });
  thread.find({refOf(1), refOf(2)});
  {
    std::unique_lock lock(mutex);
    ASSERT_TRUE(woken.wait_for(lock, 300s, [&] { return wakes == 2; }));
  }
  std::map<uint32_t, bool> found;
  for (const CacheThread::Answer& answer : thread.takeAnswers())
    found[answer.blob.number] = answer.bytes.has_value();
  EXPECT_EQ(found, (std::map<uint32_t, bool>{{1, true}, {2, false}}));
  EXPECT_TRUE(thread.takeAnswers().empty());
}

}  // namespace
}  // namespace lode::stream
