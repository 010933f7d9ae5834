#include "server/ingest/disk/journal.h"

#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/support/work_folder.h"
#include "tests/unit/ingest/disk/synced_files.h"
#include "tests/unit/memory_meter.h"

namespace lode::ingest {
namespace {

using Entries = std::vector<std::pair<uint32_t, std::string>>;

const Entries kWritten{{1, "the first"}, {7, ""}, {2, std::string(100, 'x')}, {7, "the last"}};
constexpr size_t kEntryHeaderBytes = 32;

class JournalFile : public testing::Test {
 protected:
  void SetUp() override {
    Journal journal = Journal::create(path_);
    for (const auto& [kind, text] : kWritten) append(journal, kind, text);
    EXPECT_EQ(journal.entries(), kWritten.size());
    std::ifstream in(path_, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
  }

  static void append(Journal& journal, uint32_t kind, std::string_view text) {
    journal.append(kind, std::as_bytes(std::span(text)));
  }

  void put(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }

  Entries read() const {
    open();
    return entries_;
  }

  Journal open() const {
    entries_.clear();
    return Journal::open(path_, [this](uint32_t kind, std::span<const std::byte> bytes) {
      entries_.emplace_back(kind, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    });
  }

  static Entries first(size_t count) {
    return {kWritten.begin(), kWritten.begin() + static_cast<ptrdiff_t>(count)};
  }

  /// Size of the file with this number of entries.
  static size_t end(size_t count) {
    size_t bytes = 8;
    for (size_t i = 0; i < count; ++i) bytes += kEntryHeaderBytes + kWritten[i].second.size();
    return bytes;
  }

  test::WorkFolder folder_;
  const std::filesystem::path path_ = folder_ / "journal";
  std::string bytes_;
  mutable Entries entries_;
};

TEST_F(JournalFile, readsItsEntriesInOrder) { EXPECT_EQ(read(), kWritten); }

TEST_F(JournalFile, givesTheEntriesBeforeATornOne) {
  for (size_t count = 0; count < kWritten.size(); ++count) {
    for (size_t bytes = end(count); bytes < end(count + 1); ++bytes) {
      put(bytes_.substr(0, bytes));
      ASSERT_EQ(read(), first(count)) << bytes;
    }
  }
}

TEST_F(JournalFile, givesTheEntriesBeforeOneWithAnyByteChanged) {
  for (size_t count = 0; count < kWritten.size(); ++count) {
    for (size_t at = end(count); at < end(count + 1); ++at) {
      std::string changed = bytes_;
      changed[at] = static_cast<char>(changed[at] ^ 0x10);
      put(changed);
      ASSERT_EQ(read(), first(count)) << at;
    }
  }
}

TEST_F(JournalFile, appendsAfterTheLastWholeEntry) {
  put(bytes_.substr(0, bytes_.size() - 1));
  Journal journal = open();
  append(journal, 9, "new");
  Entries expected = first(kWritten.size() - 1);
  expected.emplace_back(9, "new");
  EXPECT_EQ(read(), expected);
}

TEST_F(JournalFile, hasAnEntryOnTheDiskWhenItIsAppended) {
  Journal journal = open();
  const test::SyncedFiles synced;
  append(journal, 9, "new");
  EXPECT_TRUE(synced.names().contains(path_.filename().string()));
}

TEST_F(JournalFile, cutsATornEntryOff) {
  put(bytes_.substr(0, bytes_.size() - 1));
  open();
  EXPECT_EQ(std::filesystem::file_size(path_), end(kWritten.size() - 1));
}

TEST_F(JournalFile, isEmptyWithoutItsFirstByte) {
  put("");
  EXPECT_EQ(read(), Entries());
}

TEST_F(JournalFile, isRefusedWhenItIsOfAnotherVersion) {
  for (size_t at = 0; at < 8; ++at) {
    std::string changed = bytes_;
    ++changed[at];
    put(changed);
    EXPECT_THROW(read(), Error) << at;
  }
  put("LODE");
  EXPECT_THROW(read(), Error);
}

TEST_F(JournalFile, allocatesNothingForALengthBeyondTheFile) {
  for (const uint64_t length : {uint64_t{1} << 20, Journal::kMaxEntryBytes + 1, ~uint64_t{0}}) {
    std::string changed = bytes_;
    changed.replace(end(1) + 16, sizeof length, reinterpret_cast<const char*>(&length), sizeof length);
    put(changed);
    const test::MemoryMeter meter;
    EXPECT_EQ(read(), first(1));
    EXPECT_LT(meter.peakBytes(), 1 << 17);
  }
}

TEST_F(JournalFile, ignoresAMisplacedEntry) {
  put(bytes_.substr(0, end(1)) + bytes_.substr(end(2)));
  EXPECT_EQ(read(), first(1));
}

TEST_F(JournalFile, startsEmptyWhenItReplacesAnother) {
  Journal::create(path_);
  EXPECT_TRUE(read().empty());
}

}  // namespace
}  // namespace lode::ingest
