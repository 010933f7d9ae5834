#include "server/serve/memory_reserve.h"

#include <cstdio>
#include <cstdlib>
#include <new>
#include <thread>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "tests/unit/serve/allocations.h"

namespace lode::serve {
namespace {

using test::FailingAllocations;

constexpr size_t kBytes = 12'345;

void allocate() { ::operator delete(::operator new(kBytes)); }  // which no compiler leaves out

#ifndef LODE_SANITIZED  // whose allocators end the process instead

/// As if the system had no more: no new memory from now on, and what malloc has in hand is taken.
void takeAllMemory() {
  const rlimit none{0, 0};
  setrlimit(RLIMIT_AS, &none);
  setrlimit(RLIMIT_DATA, &none);
  for (size_t bytes = 1u << 20; bytes >= 16; bytes /= 2)
    while (std::malloc(bytes) != nullptr) {
    }
}

size_t countOf(size_t bytes) {
  size_t count = 0;
  try {
    for (;; ++count) static_cast<void>(::operator new(bytes));
  } catch (const std::bad_alloc&) {
    return count;
  }
}

TEST(MemoryReserveDeathTest, isLetGoForWhatNeedsALittleEvenAfterManyHaveAskedForMuch) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        const MemoryReserve reserve;
        takeAllMemory();
        size_t given = 0;
        for (int i = 0; i < 20; ++i) given += countOf(1u << 20);
        const size_t little = countOf(MemoryReserve::kBlockBytes / 2);
        std::fprintf(stderr, "%zu much, %zu little\n", given, little);
        std::exit(given == 0 && little >= MemoryReserve::kBlocks ? 0 : 1);
      },
      testing::ExitedWithCode(0), "0 much");
}

#endif

TEST(MemoryReserve, isNotTouchedWhereAnotherTryIsEnough) {
  MemoryReserve reserve;
  {
    const auto failing = FailingAllocations::nthOf(std::this_thread::get_id(), 0);
    EXPECT_NO_THROW(allocate());
  }
  EXPECT_EQ(reserve.refill(), 0u);
}

TEST(MemoryReserve, isNotTouchedByWhoFindsNoMemoryWhereABlockIsThere) {
  MemoryReserve reserve;
  {
    const auto failing = FailingAllocations::ofSize(kBytes, kBytes);
    EXPECT_THROW(allocate(), std::bad_alloc);
  }
  EXPECT_EQ(reserve.refill(), 0u);
}

TEST(MemoryReserve, leavesTheHandlerThatWasThere) {
  { const MemoryReserve reserve; }
  EXPECT_EQ(std::get_new_handler(), nullptr);
  EXPECT_THROW(
      {
        const auto failing = FailingAllocations::ofSize(kBytes, kBytes);
        allocate();
      },
      std::bad_alloc);
}

}  // namespace
}  // namespace lode::serve
