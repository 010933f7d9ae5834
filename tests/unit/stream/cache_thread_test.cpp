#include "client/stream/cache_thread.h"

#include <map>

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
