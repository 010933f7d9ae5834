#include "server/serve/memory_reserve.h"

#include <new>
#include <thread>

#include <gtest/gtest.h>

#include "tests/unit/serve/allocations.h"

namespace lode::serve {
namespace {

using test::FailingAllocations;

constexpr size_t kBytes = 12'345;

void allocate() { ::operator delete(::operator new(kBytes)); }  // which no compiler leaves out

TEST(MemoryReserve, isLetGoBlockByBlockForWhatFindsNoMemory) {
  MemoryReserve reserve;
  for (size_t i = 0; i < 3; ++i) {
    const auto failing = FailingAllocations::nthOf(std::this_thread::get_id(), 0);
    EXPECT_NO_THROW(allocate());
  }
  EXPECT_EQ(reserve.refill(), 3u);
  EXPECT_EQ(reserve.refill(), 0u);
}

TEST(MemoryReserve, doesNotHelpWhoAsksForMoreThanThereIs) {
  MemoryReserve reserve;
  {
    const auto failing = FailingAllocations::ofSize(kBytes, kBytes);
    EXPECT_THROW(allocate(), std::bad_alloc);
  }
  EXPECT_EQ(reserve.refill(), MemoryReserve::kBlocks);
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
