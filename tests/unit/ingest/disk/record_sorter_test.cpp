#include "server/ingest/disk/record_sorter.h"

#include <algorithm>
#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

using Pair = std::pair<uint64_t, uint64_t>;

std::vector<Pair> sortWith(uint64_t memory_bytes, const std::vector<Pair>& input,
                           uint64_t* temporary_bytes = nullptr, unsigned threads = 1) {
  const TemporaryFolder folder(testing::TempDir());
  RecordSorter sorter(sizeof(uint64_t), memory_bytes, folder.file("test"), threads);
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

TEST(RecordSorter, givesTheSameOrderOnAnyNumberOfThreads) {
  const std::vector<Pair> pairs = randomPairs(1'500'000, 1000);
  const std::vector<Pair> sorted = sortWith(1 << 30, pairs);
  EXPECT_EQ(sortWith(1 << 30, pairs, nullptr, 5), sorted);
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

TEST(RecordSorter, reportsProgressIncludingBufferedRecords) {
  for (const uint64_t memory_bytes : {uint64_t{1} << 30, uint64_t{16} << 20}) {
    const TemporaryFolder folder(testing::TempDir());
    RecordSorter sorter(sizeof(uint64_t), memory_bytes, folder.file("test"));
    for (const auto& [key, value] : randomPairs(1200000, 100))
      sorter.push(key, std::as_bytes(std::span(&value, 1)));
    std::vector<uint64_t> told;
    sorter.finish([&](uint64_t done, uint64_t total) {
      EXPECT_LE(done, total);
      told.push_back(done);
    });
    EXPECT_GT(told.size(), 2u);
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  }
}

TEST(RecordSorter, continuesWithSavedRuns) {
  const std::vector<Pair> pairs = randomPairs(20000, 100);
  const auto push = [](RecordSorter& sorter, std::span<const Pair> some) {
    for (const auto& [key, value] : some) sorter.push(key, std::as_bytes(std::span(&value, 1)));
  };
  const test::WorkFolder work;
  const TemporaryFolder folder = TemporaryFolder::lasting(work / "files");
  RecordWriter record;
  {
    RecordSorter sorter(sizeof(uint64_t), 40000, folder.lastingFile("runs"));
    push(sorter, std::span(pairs).first(10000));
    sorter.save(record);
    push(sorter, std::span(pairs).subspan(10000, 3000));  // not saved before the kill
  }
  RecordSorter sorter(sizeof(uint64_t), 60000, folder.lastingFile("runs"));
  RecordReader reader(record.bytes());
  sorter.restore(reader);
  const uint64_t saved = sorter.size();
  EXPECT_GT(saved, 5000u);
  EXPECT_LE(saved, 10000u);
  push(sorter, std::span(pairs).subspan(saved));
  sorter.finish();
  std::vector<Pair> output;
  while (const auto next = sorter.next()) {
    uint64_t value = 0;
    std::memcpy(&value, next->bytes.data(), sizeof(value));
    output.emplace_back(next->key, value);
  }
  EXPECT_EQ(output, sortWith(1 << 30, pairs));
}

TEST(RecordSorter, refusesToContinueWithMissingRuns) {
  const test::WorkFolder work;
  const TemporaryFolder folder = TemporaryFolder::lasting(work / "files");
  for (const std::vector<uint64_t>& ends :
       {std::vector<uint64_t>{16}, std::vector<uint64_t>{17}, std::vector<uint64_t>{32, 16}}) {
    RecordWriter record;
    record.putAll(ends);
    RecordReader reader(record.bytes());
    RecordSorter sorter(sizeof(uint64_t), 40000, folder.lastingFile("runs"));
    EXPECT_THROW(sorter.restore(reader), Error);
  }
}

TEST(RecordSorter, givesNothingWithoutRecords) { EXPECT_TRUE(sortWith(1 << 20, {}).empty()); }

}  // namespace
}  // namespace lode::ingest
