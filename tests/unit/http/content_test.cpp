#include <array>
#include <future>
#include <optional>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/http/content_cache.h"
#include "server/http/content_makers.h"
#include "server/http/gzip.h"

namespace lode::http {
namespace {

constexpr size_t kBytes = 1000;

std::unique_ptr<const Content> contentOf(size_t bytes = kBytes) {
  return std::make_unique<FileContent>(std::vector<std::byte>(bytes), std::vector<std::byte>());
}

TEST(ContentCacheTest, evictsTheLeastRecentlyUsed) {
  ContentCache cache(3 * 1500);
  for (const char* const key : {"a", "b", "c"}) EXPECT_TRUE(cache.add(key, contentOf()));
  EXPECT_TRUE(cache.find("a"));
  EXPECT_TRUE(cache.add("d", contentOf()));
  EXPECT_TRUE(cache.find("a"));
  EXPECT_FALSE(cache.find("b"));
  EXPECT_TRUE(cache.find("c"));
  EXPECT_LE(cache.usedBytes(), cache.limitBytes());
}

TEST(ContentCacheTest, countsEvictedContentsThatAreStillUsed) {
  ContentCache cache(3 * 1500);
  std::vector<std::shared_ptr<const Content>> used;
  for (const char* const key : {"a", "b", "c"}) used.push_back(cache.add(key, contentOf()));
  EXPECT_FALSE(cache.add("d", contentOf())) << "the contents in use fill the memory";
  const uint64_t before = cache.usedBytes();
  used.clear();
  EXPECT_LT(cache.usedBytes(), before);
  EXPECT_TRUE(cache.add("d", contentOf()));
}

TEST(ContentCacheTest, refusesAContentAboveTheLimit) {
  ContentCache cache(500);
  EXPECT_FALSE(cache.add("a", contentOf()));
  EXPECT_EQ(cache.usedBytes(), 0);
}

TEST(ContentCacheTest, replacesAContentOfTheSameKey) {
  ContentCache cache(1 << 20);
  cache.add("a", contentOf());
  const uint64_t once = cache.usedBytes();
  cache.add("a", contentOf());
  EXPECT_EQ(cache.usedBytes(), once);
}

TEST(ContentCacheTest, erasesStaleContents) {
  ContentCache cache(1 << 20);
  cache.add("old a", contentOf());
  cache.add("new a", contentOf());
  cache.eraseIf([](const std::string& key) { return key.starts_with("old"); });
  EXPECT_FALSE(cache.find("old a"));
  EXPECT_TRUE(cache.find("new a"));
}

class Makers : public testing::Test {
 protected:
  struct Result {
    MakeResult result;
    std::shared_ptr<const Content> content;
  };

  /// Asks for a content. @return nothing if the queue is full.
  std::optional<std::future<Result>> ask(const std::string& key, ContentMakers::Make make) {
    const auto promise = std::make_shared<std::promise<Result>>();
    auto future = promise->get_future();
    const bool is_queued = makers_.make(key, std::move(make),
                                        [promise](MakeResult result, std::shared_ptr<const Content> content) {
                                          promise->set_value({result, std::move(content)});
                                        });
    if (!is_queued) return {};
    return future;
  }
  /// Returns a function that waits until open_ has a value.
  ContentMakers::Make gated() {
    return [gate = gate_, this] {
      ++made_;
      gate.wait();
      return contentOf();
    };
  }

  std::promise<void> open_;
  std::shared_future<void> gate_ = open_.get_future().share();
  std::atomic<int> made_{0};
  ContentMakers makers_{{.threads = 1, .queue = 2, .memory_bytes = 1 << 20}};
};

TEST(FileContentTest, countsNoMemoryForConstantBytes) {
  static constexpr std::array<std::byte, kBytes> kConstant{};
  const FileContent content(std::span<const std::byte>(kConstant), std::vector<std::byte>(10));
  EXPECT_EQ(content.plain().data(), kConstant.data());
  EXPECT_EQ(content.plain().size(), kBytes);
  EXPECT_LT(content.memoryBytes(), kBytes);
}

TEST_F(Makers, makeAContentOnceForAllThatAskForIt) {
  auto first = ask("a", gated()), second = ask("a", gated());
  open_.set_value();
  const Result one = first->get(), other = second->get();
  EXPECT_EQ(one.result, MakeResult::kDone);
  EXPECT_EQ(one.content, other.content);
  EXPECT_EQ(made_, 1);
  EXPECT_EQ(makers_.find("a"), one.content);
}

TEST_F(Makers, refuseWhenTheQueueIsFull) {
  auto running = ask("a", gated());
  while (made_ == 0) std::this_thread::yield();
  auto second = ask("b", gated()), third = ask("c", gated());
  EXPECT_FALSE(ask("d", gated()));
  auto joined = ask("a", gated());
  EXPECT_TRUE(joined) << "waiting for a content that is being made needs no place in the queue";
  open_.set_value();
  EXPECT_EQ(third->get().result, MakeResult::kDone);
  EXPECT_EQ(joined->get().result, MakeResult::kDone);
}

TEST_F(Makers, reportAFailure) {
  EXPECT_EQ(
      ask("a", []() -> std::unique_ptr<const Content> { throw std::runtime_error("no"); })->get().result,
      MakeResult::kFailed);
  EXPECT_EQ(ask("a", [] { return contentOf(); })->get().result, MakeResult::kDone);
}

TEST_F(Makers, tellFailingStorageFromDamage) {
  const auto failing = [](ErrorCode code) {
    return [code]() -> std::unique_ptr<const Content> { throw Error(code, "no"); };
  };
  EXPECT_EQ(ask("a", failing(ErrorCode::kIo))->get().result, MakeResult::kUnreadable);
  EXPECT_EQ(ask("a", failing(ErrorCode::kFormat))->get().result, MakeResult::kFailed);
}

TEST_F(Makers, reportThatTheMemoryIsUsedUp) {
  EXPECT_EQ(ask("a", [] { return contentOf(2 << 20); })->get().result, MakeResult::kBusy);
}

TEST_F(Makers, callNoFunctionAfterJoin) {
  auto running = ask("a", gated()), waiting = ask("b", gated());
  while (made_ == 0) std::this_thread::yield();
  makers_.join();  // gives up on the running function
  open_.set_value();
  EXPECT_FALSE(ask("c", gated()));
  EXPECT_THROW(running->get(), std::future_error);
  EXPECT_THROW(waiting->get(), std::future_error);
  EXPECT_EQ(made_, 1);
}

TEST(Gzip, isDeterministicAndShorter) {
  const std::vector<std::byte> text(10'000, std::byte{'a'});
  const std::vector<std::byte> packed = gzip(text);
  EXPECT_LT(packed.size(), 100);
  EXPECT_EQ(packed[0], std::byte{0x1F});
  EXPECT_EQ(packed[1], std::byte{0x8B});
  EXPECT_EQ(gzip(text), packed);
  EXPECT_LE(gzip(text, kGzipMost).size(), packed.size());
}

}  // namespace
}  // namespace lode::http
