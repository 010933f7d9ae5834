#include "server/ingest/record_sorter.h"

#include <algorithm>
#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

using Pair = std::pair<uint64_t, uint64_t>;

std::vector<Pair> sortWith(uint64_t memory_bytes, const std::vector<Pair>& input,
                           uint64_t* temporary_bytes = nullptr) {
  const TemporaryFolder folder(testing::TempDir());
  RecordSorter sorter(sizeof(uint64_t), memory_bytes, folder.file("test"));
  for (const auto& [key, value] : input) sorter.push(key, std::as_bytes(std::span(&value, 1)));
  sorter.finish();
  if (temporary_bytes) *temporary_bytes = sorter.temporaryBytes();
  std::vector<Pair> output;
  while (const auto record = sorter.next()) {
    uint64_t value = 0;
    std::memcpy(&value, record->bytes.data(), sizeof(value));
    output.emplace_back(record->key, value);
  }
  return output;
}

std::vector<Pair> randomPairs(size_t count, uint64_t keys) {
  std::mt19937_64 random(7);
  std::vector<Pair> pairs;
  for (size_t i = 0; i < count; ++i) pairs.emplace_back(random() % keys, i);
  return pairs;
}

TEST(RecordSorter, sortsByKeyAndKeepsTheOrderOfEqualKeys) {
  std::vector<Pair> pairs = randomPairs(20000, 100);
  const std::vector<Pair> sorted = sortWith(1 << 30, pairs);
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.first < b.first; });
  EXPECT_EQ(sorted, pairs);
}

TEST(RecordSorter, givesTheSameOrderWhateverTheMemory) {
  const std::vector<Pair> pairs = randomPairs(20000, 100);
  EXPECT_EQ(sortWith(1 << 30, pairs), sortWith(40000, pairs));
}

TEST(RecordSorter, writesNothingWhenTheRecordsFitInMemory) {
  uint64_t temporary_bytes = 1;
  sortWith(1 << 30, randomPairs(1000, 100), &temporary_bytes);
  EXPECT_EQ(temporary_bytes, 0u);
}

TEST(RecordSorter, writesEachRecordOnceWhenTheyDoNotFit) {
  uint64_t temporary_bytes = 0;
  sortWith(40000, randomPairs(20000, 100), &temporary_bytes);
  EXPECT_EQ(temporary_bytes, 20000u * 16);
}

TEST(RecordSorter, keepsOneFileForAnyNumberOfRunsAndRemovesItWithTheLastRecord) {
  const test::WorkFolder work;
  const TemporaryFolder folder(work.path());
  RecordSorter sorter(sizeof(uint64_t), 40000, folder.file("test"));
  for (const auto& [key, value] : randomPairs(100000, 100))
    sorter.push(key, std::as_bytes(std::span(&value, 1)));
  sorter.finish();
  const size_t folder_alone = 1;
  EXPECT_EQ(work.contents().size(), folder_alone + 1);
  while (sorter.next()) {
  }
  EXPECT_EQ(work.contents().size(), folder_alone);
}

TEST(RecordSorter, givesNothingOfNothing) { EXPECT_TRUE(sortWith(1 << 20, {}).empty()); }

}  // namespace
}  // namespace lode::ingest
