#include "server/serve/memory/memory_reserve.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <thread>

#include <gtest/gtest.h>

#include "tests/unit/serve/allocations.h"

namespace lode::serve {
namespace {

using test::FailingAllocations;

constexpr size_t kLittle = 876, kMuch = 1'234;

void allocate(size_t bytes) {
  ::operator delete(::operator new(bytes));
}  // compilers may elide new expressions, but not these calls

TEST(MemoryReserve, providesABlockWhenMemoryRunsOut) {
  const MemoryReserve reserve;
  const size_t before = MemoryReserve::taken();
  for (size_t i = 0; i < 3; ++i) {
    const auto failing = FailingAllocations::nthOf(std::this_thread::get_id(), 0);
    EXPECT_NO_THROW(allocate(kLittle));
  }
  EXPECT_EQ(MemoryReserve::taken() - before, 3u);
}

TEST(MemoryReserve, isNotUsedForLargeAllocations) {
  const MemoryReserve reserve;
  const size_t before = MemoryReserve::taken();
  const auto failing = FailingAllocations::ofSize(kMuch, kMuch);
  EXPECT_THROW(allocate(kMuch), std::bad_alloc);
  EXPECT_EQ(MemoryReserve::taken(), before);
}

TEST(MemoryReserve, isNotForThreadsThatAbstain) {
  const MemoryReserve reserve;
  const size_t before = MemoryReserve::taken();
  {
    const MemoryReserve::Abstention abstention;
    const auto failing = FailingAllocations::nthOf(std::this_thread::get_id(), 0);
    EXPECT_THROW(allocate(kLittle), std::bad_alloc);
  }
  EXPECT_EQ(MemoryReserve::taken(), before);
  const auto failing = FailingAllocations::nthOf(std::this_thread::get_id(), 0);
  EXPECT_NO_THROW(allocate(kLittle));
}

TEST(MemoryReserve, endsAndIsRefilled) {
  const auto failing = FailingAllocations::ofSize(kLittle, kLittle);
  const auto count = [] {
    size_t given = 0;
    while (void* const block = MemoryReserve::take(kLittle)) {
      std::free(block);  // NOLINT(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory)
      ++given;
    }
    return given;
  };
  {
    const MemoryReserve reserve;
    EXPECT_EQ(count(), MemoryReserve::kBlocks);
    EXPECT_THROW(allocate(kLittle), std::bad_alloc);
    EXPECT_TRUE(MemoryReserve::refill());
    EXPECT_EQ(count(), MemoryReserve::kBlocks);
  }
  { const MemoryReserve reserve; }
  EXPECT_EQ(count(), 0u);
}

#ifndef LODE_SANITIZED  // sanitizers end the process when memory runs out

size_t countOf(size_t bytes) {
  size_t count = 0;
  try {
    for (;; ++count) static_cast<void>(::operator new(bytes));
  } catch (const std::bad_alloc&) {
    return count;
  }
}

/// Allocates on a new thread, for which malloc must make an arena or fail.
[[noreturn]] void askWhereThereIsNone() {
  const MemoryReserve reserve;
  std::atomic<bool> is_all_taken = false;
  size_t much = 0, little = 0;
  std::thread fresh([&] {
    is_all_taken.wait(false);
    for (int i = 0; i < 20; ++i) much += countOf(1u << 20);
    little = countOf(kLittle);
  });
  test::takeAllMemory();
  is_all_taken = true;
  is_all_taken.notify_one();
  fresh.join();
  std::fprintf(stderr, "%zu much, %zu little\n", much, little);
  std::_Exit(0);
}

TEST(MemoryReserveDeathTest, existsOnEveryThreadEvenAfterLargeAllocations) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(askWhereThereIsNone(), testing::ExitedWithCode(0), "0 much, 1024 little");
}

#endif

}  // namespace
}  // namespace lode::serve
