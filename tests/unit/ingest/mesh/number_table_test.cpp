#include "server/ingest/mesh/number_table.h"

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

TEST(NumberTable, keepsManyMoreKeysThanExpected) {
  NumberTable table;
  for (int round = 0; round < 2; ++round) {
    table.reset(1);
    for (uint32_t i = 0; i < 10000; ++i) EXPECT_EQ(table.findOrAdd(uint64_t{i} << 32, i), i);
    for (uint32_t i = 0; i < 10000; ++i) EXPECT_EQ(table.findOrAdd(uint64_t{i} << 32, 77777), i);
  }
}

TEST(NumberTable, forgetsAllWhenItIsReset) {
  NumberTable table;
  table.reset(100);
  table.findOrAdd(5, 1);
  table.reset(10);
  EXPECT_EQ(table.findOrAdd(5, 2), 2u);
}

}  // namespace
}  // namespace lode::ingest
