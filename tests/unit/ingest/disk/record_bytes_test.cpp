#include "server/ingest/disk/record_bytes.h"

#include <gtest/gtest.h>

namespace lode::ingest {
namespace {

RecordWriter sampleRecord() {
  RecordWriter record;
  record.put(uint32_t{7});
  record.putAll(std::vector<uint16_t>{1, 2, 3});
  record.putText("text");
  return record;
}

void readAll(std::span<const std::byte> bytes) {
  RecordReader record(bytes);
  EXPECT_EQ(record.get<uint32_t>(), 7u);
  EXPECT_EQ(record.getAll<uint16_t>(), (std::vector<uint16_t>{1, 2, 3}));
  EXPECT_EQ(record.getText(), "text");
  EXPECT_TRUE(record.atEnd());
}

TEST(RecordBytes, readBackWrittenValues) { readAll(sampleRecord().bytes()); }

TEST(RecordBytes, areRefusedWhenTheyEndTooEarly) {
  const RecordWriter record = sampleRecord();
  for (size_t bytes = 0; bytes < record.bytes().size(); ++bytes)
    EXPECT_THROW(readAll(record.bytes().first(bytes)), Error) << bytes;
}

TEST(RecordBytes, allocateNothingForMoreItemsThanTheyHold) {
  for (const uint64_t count : {uint64_t{5}, uint64_t{1} << 40, ~uint64_t{0}}) {
    RecordWriter record;
    record.put(count);
    record.put(uint64_t{0});
    RecordReader items(record.bytes()), text(record.bytes());
    EXPECT_THROW(items.getAll<uint16_t>(), Error) << count;
    if (count > 8) {
      EXPECT_THROW(text.getText(), Error) << count;
    }
  }
}

}  // namespace
}  // namespace lode::ingest
