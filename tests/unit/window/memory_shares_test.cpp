#include "client/app/window/memory_shares.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

TEST(MemoryShares, haveBuffersThatAreQuickToAllocate) {
  for (const uint64_t memory_bytes : {uint64_t{16} << 20, uint64_t{1} << 30, uint64_t{64} << 30}) {
    const MemoryShares shares = shareMemory(memory_bytes);
    EXPECT_LE(shares.gpu.page_bytes, 4u << 20) << memory_bytes;
    EXPECT_GE(shares.gpu.page_bytes, 256u << 10) << memory_bytes;
  }
}

}  // namespace
}  // namespace lode::app
