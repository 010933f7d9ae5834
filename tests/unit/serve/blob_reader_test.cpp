#include "server/serve/session/blob_reader.h"

#include <cerrno>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/uio.h>

#include "tests/unit/serve/small_store.h"

namespace lode::serve {
namespace {

namespace fs = std::filesystem;

class BlobReaderTest : public testing::Test {
 protected:
  BlobReaderTest() { test::writeSmallStore(path_); }

  BlobReader open() { return BlobReader(store::Reader(path_), options_); }
  std::vector<std::byte> blob(uint32_t number) const { return store::Reader(path_).readBlob(number); }
  static BlobRange whole(const BlobReader& reader, uint32_t number) {
    return {number, 0, reader.store().blob(number).bytes};
  }
  void damageBlob(uint32_t number) { test::damage(path_, store::Reader(path_).blob(number).offset + 5000); }
  /// Reads from the page cache, which holds the small stores that were just written.
  static ReadResult read(const BlobReader& reader, const BlobRange& range, std::vector<std::byte>& into) {
    into.resize(range.bytes);
    const ReadResult hot = reader.readHot(range, into);
    return hot == ReadResult::kCold ? reader.readCold(range, into) : hot;
  }

  test::WorkFolder folder_;
  const fs::path path_ = folder_.path() / "a.lode";
  std::vector<std::string> reports_;
  BlobReaderOptions options_{.check_file_every = std::chrono::nanoseconds(0),
                             .retry_damaged = std::chrono::seconds(1000),
                             .report =
                                 [this](StoreFault fault, std::string_view line) {
                                   faults_.push_back(fault);
                                   reports_.emplace_back(line);
                                 },
                             .read =
                                 [this](int file, uint64_t offset, std::span<std::byte> into) {
                                   if (fault_ == 0) return readAt(file, offset, into);
                                   errno = fault_;
                                   return std::optional<size_t>();
                                 }};
  int fault_ = 0;  ///< errno with which reads fail; 0: they succeed
  std::vector<StoreFault> faults_;
  std::vector<std::byte> bytes_;
};

TEST_F(BlobReaderTest, theFirstReadOfABlobIsHotIfThePageCacheHasIt) {
  const BlobReader reader = open();
  const BlobRange range = whole(reader, 2);
  bytes_.resize(range.bytes);
  const ReadResult first = reader.readHot(range, bytes_);
  std::byte byte{};
  const iovec into{&byte, 1};
  if (preadv2(reader.store().fileDescriptor(), &into, 1, 0, RWF_NOWAIT) < 0 && errno == EOPNOTSUPP)
    GTEST_SKIP() << "this file system cannot say what is in the page cache";
  EXPECT_EQ(first, ReadResult::kDone);
  EXPECT_EQ(bytes_, blob(2));
}

TEST_F(BlobReaderTest, readsEveryBlobHotOnTmpfs) {
  if (!fs::is_directory("/dev/shm")) GTEST_SKIP();
  std::string name = "/dev/shm/lode-serve-XXXXXX";
  const fs::path folder = mkdtemp(name.data());
  test::writeSmallStore(folder / "a.lode");
  const BlobReader reader(store::Reader(folder / "a.lode"), options_);
  const BlobRange range = whole(reader, 2);
  std::vector<std::byte> bytes(range.bytes);
  EXPECT_EQ(reader.readHot(range, bytes), ReadResult::kDone);
  EXPECT_EQ(reader.readHot(range, bytes), ReadResult::kDone);
  EXPECT_EQ(bytes, blob(2));
  fs::remove_all(folder);
}

TEST_F(BlobReaderTest, readsTheRangeAtAnOffset) {
  const std::vector<std::byte> all = blob(1);
  const std::vector<std::byte> expected(all.begin() + 700, all.begin() + 1200);
  const BlobReader reader = open();
  for (int time = 0; time < 2;
       ++time) {  // the first read verifies the whole blob, the second reads the range only
    EXPECT_EQ(read(reader, {1, 700, 500}, bytes_), ReadResult::kDone);
    EXPECT_EQ(bytes_, expected);
  }
}

TEST_F(BlobReaderTest, readsTheSameBytesCold) {
  const std::vector<std::byte> all = blob(1);
  const BlobReader reader = open();
  for (int time = 0; time < 2; ++time) {
    std::vector<std::byte> bytes(500);
    EXPECT_EQ(reader.readCold({1, 700, 500}, bytes), ReadResult::kDone);
    EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), all.begin() + 700));
  }
}

TEST_F(BlobReaderTest, reportsADamagedBlobOnce) {
  const BlobReader reader = open();
  damageBlob(2);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(read(reader, {2, 0, 100}, bytes_), ReadResult::kDamaged);
  EXPECT_EQ(reader.damagedReads(), 100u);
  size_t lines = 0;
  for (const std::string& line : reports_) lines += line.find("blob 2 of model 'a'") != std::string::npos;
  EXPECT_EQ(lines, 1u);
  for (const std::string& line : reports_) EXPECT_EQ(line.find(path_.string()), std::string::npos) << line;
}

TEST_F(BlobReaderTest, aBlobOverwrittenAfterItsCheckIsNoticed) {
  const BlobReader reader = open();
  ASSERT_EQ(read(reader, {2, 0, 100}, bytes_), ReadResult::kDone);
  ASSERT_EQ(read(reader, {3, 0, 100}, bytes_), ReadResult::kDone);
  damageBlob(2);
  EXPECT_EQ(read(reader, {2, 0, 100}, bytes_), ReadResult::kDamaged);
  EXPECT_EQ(read(reader, {3, 0, 100}, bytes_), ReadResult::kDone) << "the other blobs are undamaged";
  EXPECT_EQ(reports_.size(), 2u) << "one for the change, one for the blob";
}

TEST_F(BlobReaderTest, aDamagedBlobThatIsMendedIsServedAgain) {
  const BlobReader reader = open();
  damageBlob(2);
  EXPECT_EQ(read(reader, {2, 0, 100}, bytes_), ReadResult::kDamaged);
  damageBlob(2);  // restores the same bit
  EXPECT_EQ(read(reader, {2, 0, 100}, bytes_), ReadResult::kDone);
}

TEST_F(BlobReaderTest, aDamagedBlobIsTriedAgainAfterItsTimeEvenIfNothingSeemsChanged) {
  options_.retry_damaged = std::chrono::seconds(0);
  options_.check_file_every = std::chrono::hours(1);
  const BlobReader reader = open();
  damageBlob(2);
  EXPECT_EQ(read(reader, {2, 0, 100}, bytes_), ReadResult::kDamaged);
  damageBlob(2);
  EXPECT_EQ(read(reader, {2, 0, 100}, bytes_), ReadResult::kDone);
}

TEST_F(BlobReaderTest, aFileThatWasTruncatedIsDamagedAndReportedByBlob) {
  const BlobReader reader = open();
  ASSERT_EQ(read(reader, whole(reader, 3), bytes_), ReadResult::kDone);
  fs::resize_file(path_, 1000);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(read(reader, {3, 0, 100}, bytes_), ReadResult::kDamaged);
    EXPECT_EQ(read(reader, {4, 0, 100}, bytes_), ReadResult::kDamaged);
  }
  EXPECT_EQ(reports_.size(), 3u) << "the change and two blobs";
}

TEST_F(BlobReaderTest, aReadThatTheSystemRefusesIsUnreadableAndNotDamaged) {
  const BlobReader reader = open();
  std::vector<std::byte> bytes(100);
  ASSERT_EQ(reader.readCold({3, 0, 100}, bytes), ReadResult::kDone);
  for (const int error : {EIO, ENOTCONN, ESTALE, ETIMEDOUT, ENXIO, EREMOTEIO}) {
    fault_ = error;
    EXPECT_EQ(reader.readCold({2, 0, 100}, bytes), ReadResult::kUnreadable) << "a blob that is not verified";
    EXPECT_EQ(reader.readCold({3, 0, 100}, bytes), ReadResult::kUnreadable) << "a blob that is verified";
  }
  EXPECT_EQ(reader.damagedReads(), 0u);
  EXPECT_EQ(faults_, std::vector{StoreFault::kUnreadable});
  EXPECT_EQ(reports_[0],
            "the store of model 'a' cannot be read: Input/output error; requests end with an error "
            "until it can be read");
}

TEST_F(BlobReaderTest, servesAndReportsAReadableStoreAgainAtOnce) {
  options_.report_unreadable_every = std::chrono::seconds(0);
  const BlobReader reader = open();
  std::vector<std::byte> bytes(100);
  for (int time = 0; time < 3; ++time) {
    fault_ = EIO;
    for (int i = 0; i < 10; ++i) EXPECT_EQ(reader.readCold({2, 0, 100}, bytes), ReadResult::kUnreadable);
    fault_ = 0;
    for (int i = 0; i < 10; ++i) EXPECT_EQ(reader.readCold({2, 0, 100}, bytes), ReadResult::kDone);
  }
  ASSERT_EQ(reports_.size(), 6u);
  EXPECT_NE(reports_[4].find("cannot be read: "), std::string::npos) << reports_[4];
  EXPECT_EQ(reports_[5], "the store of model 'a' can be read again");
}

TEST_F(BlobReaderTest, limitsLogLinesForAPartlyUnreadableStore) {
  const BlobReader reader = open();
  std::vector<std::byte> bytes(100);
  for (int time = 0; time < 1000; ++time) {
    fault_ = time % 2 == 0 ? EIO : 0;
    reader.readCold({2, 0, 100}, bytes);
  }
  EXPECT_EQ(reports_.size(), 2u);
}

TEST_F(BlobReaderTest, aLateReadIsReportedAsUnreadable) {
  const BlobReader reader = open();
  reader.noteLateRead(std::chrono::milliseconds(1500));
  reader.noteLateRead(std::chrono::milliseconds(1500));
  ASSERT_EQ(reports_.size(), 1u);
  EXPECT_EQ(faults_[0], StoreFault::kUnreadable);
  EXPECT_NE(reports_[0].find("a read has not ended within 1.5 s"), std::string::npos) << reports_[0];
}

TEST_F(BlobReaderTest, aStoreThatIsReplacedOrRemovedIsNotCalledChangedInPlace) {
  const BlobReader reader = open();
  ASSERT_EQ(read(reader, {2, 0, 100}, bytes_), ReadResult::kDone);
  fs::rename(path_, folder_ / "kept.lode");
  EXPECT_EQ(read(reader, {2, 0, 100}, bytes_), ReadResult::kDone);
  test::writeSmallStore(folder_ / "b.lode", 2);
  fs::rename(folder_ / "b.lode", folder_ / "kept.lode");
  EXPECT_EQ(read(reader, {2, 0, 100}, bytes_), ReadResult::kDone);
  EXPECT_TRUE(reports_.empty()) << reports_.front();
}

TEST_F(BlobReaderTest, recognizesItsOpenFile) {
  const BlobReader reader = open();
  struct stat file {};
  ASSERT_EQ(::stat(path_.c_str(), &file), 0);
  EXPECT_TRUE(reader.isStill(file));
  test::writeSmallStore(folder_.path() / "b.lode", 2);
  fs::rename(folder_.path() / "b.lode", path_);
  ASSERT_EQ(::stat(path_.c_str(), &file), 0);
  EXPECT_FALSE(reader.isStill(file));
}

}  // namespace
}  // namespace lode::serve
