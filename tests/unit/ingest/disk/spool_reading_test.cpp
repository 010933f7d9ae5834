#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "common/error.h"
#include "server/ingest/disk/journal.h"
#include "server/ingest/disk/spool.h"
#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"

namespace lode::ingest {
namespace {

TEST(SpoolForReading, leavesTheFileAsItIs) {
  const test::WorkFolder folder;
  std::ofstream(folder / "file") << "0123456789";
  {
    const Spool spool = Spool::forReading(folder / "file", 4);
    char read[3];
    spool.readAt(1, std::as_writable_bytes(std::span(read)));
    EXPECT_EQ(std::string(read, 3), "123");
  }
  EXPECT_EQ(test::readBytes(folder / "file"), "0123456789");
}

TEST(SpoolForReading, refusesAFileThatIsTooShort) {
  const test::WorkFolder folder;
  std::ofstream(folder / "file") << "0123";
  EXPECT_THROW(Spool::forReading(folder / "file", 5), Error);
}

TEST(JournalForReading, leavesDamagedEntriesAsTheyAre) {
  const test::WorkFolder folder;
  const std::filesystem::path path = folder / "journal";
  Journal::create(path).append(1, test::bytesOf("an entry"));
  std::ofstream(path, std::ios::app | std::ios::binary) << "half of the next entry";
  const std::string before = test::readBytes(path);
  int entries = 0;
  Journal::read(path, [&](uint32_t kind, std::span<const std::byte>) { entries += kind == 1 ? 1 : 100; });
  EXPECT_EQ(entries, 1);
  EXPECT_EQ(test::readBytes(path), before);
}

}  // namespace
}  // namespace lode::ingest
