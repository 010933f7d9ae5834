#include "client/stream/blob_cache.h"

#include <chrono>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "common/error.h"
#include "tests/support/strangers.h"
#include "tests/support/work_folder.h"

namespace lode::stream {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> bytesOf(uint32_t number, size_t size) {
  std::vector<std::byte> bytes(size);
  for (size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(number * 31 + i * 7 + (i >> 8));
  return bytes;
}

BlobRef refOf(uint32_t number, size_t size) {
  return {number, static_cast<uint32_t>(size), digestOf(bytesOf(number, size))};
}

class BlobCacheTest : public testing::Test {
 protected:
  static constexpr uint64_t kLimit = 1u << 20;

  void keep(uint32_t number, size_t size) { cache_.keep(refOf(number, size), bytesOf(number, size)); }

  std::vector<fs::path> files() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "cache"))
      if (entry.is_regular_file()) found.push_back(entry.path());
    return found;
  }

  uint64_t bytesOnDisk() const {
    uint64_t bytes = 0;
    for (const fs::path& file : files()) bytes += fs::file_size(file);
    return bytes;
  }

  const test::WorkFolder folder_;
  BlobCache cache_{folder_ / "cache", kLimit};
};

TEST_F(BlobCacheTest, sharesBlobsBetweenProcesses) {
  keep(1, 5000);
  BlobCache other(folder_ / "cache", kLimit);
  EXPECT_EQ(other.find(refOf(1, 5000)), bytesOf(1, 5000));
  EXPECT_FALSE(other.find(refOf(2, 5000)));
}

TEST_F(BlobCacheTest, removesAnEntryThatIsDamagedOrCut) {
  keep(1, 5000);
  keep(2, 5000);
  for (const fs::path& file : files()) {
    if (fs::file_size(file) == 5000 && file.filename() == toHex(refOf(1, 5000).digest)) {
      std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(100).put('x');
    } else {
      fs::resize_file(file, 1234);
    }
  }
  EXPECT_FALSE(cache_.find(refOf(1, 5000)));
  EXPECT_FALSE(cache_.find(refOf(2, 5000)));
  EXPECT_TRUE(files().empty());
  keep(1, 5000);
  EXPECT_TRUE(cache_.find(refOf(1, 5000)));
}

TEST_F(BlobCacheTest, readsNothingButFilesOfTheBlobsOwnSize) {
  keep(1, 5000);
  const fs::path file = files().front();
  fs::resize_file(file, 1u << 30);
  EXPECT_FALSE(cache_.find(refOf(1, 5000)));
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  EXPECT_FALSE(cache_.find(refOf(1, 5000)));
  fs::remove(file);
  fs::create_directory(file);
  EXPECT_FALSE(cache_.find(refOf(1, 5000)));
}

TEST_F(BlobCacheTest, staysWithinItsLimitWhateverIsKept) {
  for (uint32_t number = 1; number <= 200; ++number) {
    keep(number, 20'000);
    EXPECT_LE(bytesOnDisk(), kLimit + kLimit / 16);
  }
  EXPECT_TRUE(cache_.find(refOf(200, 20'000)));
  EXPECT_FALSE(cache_.find(refOf(1, 20'000)));
}

TEST_F(BlobCacheTest, removesTheLeastRecentlyUsedFirst) {
  for (uint32_t number = 1; number <= 40; ++number) keep(number, 20'000);
  const auto old = fs::file_time_type::clock::now() - std::chrono::hours(24);
  for (const fs::path& file : files()) fs::last_write_time(file, old);
  EXPECT_TRUE(cache_.find(refOf(7, 20'000)));
  for (uint32_t number = 41; number <= 80; ++number) keep(number, 20'000);
  cache_.trim();
  EXPECT_TRUE(cache_.find(refOf(7, 20'000)));
  EXPECT_FALSE(cache_.find(refOf(6, 20'000)));
}

TEST_F(BlobCacheTest, removesTheTemporaryFilesOfProcessesThatDied) {
  keep(1, 100);
  const fs::path left = files().front().parent_path() / ".new-1-1";
  std::ofstream(left) << "half";
  cache_.trim();
  EXPECT_TRUE(fs::exists(left));
  fs::last_write_time(left, fs::file_time_type::clock::now() - std::chrono::hours(2));
  cache_.trim();
  EXPECT_FALSE(fs::exists(left));
}

TEST_F(BlobCacheTest, keepsNothingIfItsFolderCannotBeCreated) {
  std::ofstream(folder_ / "file") << "no folder";
  BlobCache cache(folder_ / "file" / "below", kLimit);
  cache.keep(refOf(1, 100), bytesOf(1, 100));
  EXPECT_FALSE(cache.find(refOf(1, 100)));
  EXPECT_FALSE(cache.summary({{"host", 1}, "model"}));
}

TEST_F(BlobCacheTest, isForThisUserAlone) {
  keep(1, 100);
  ModelSummary summary;
  summary.name = "model";
  cache_.keepSummary({{"host", 7400}, "model"}, summary);
  EXPECT_EQ(test::modeOf(folder_ / "cache"), 0700u);
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "cache"))
    EXPECT_EQ(test::modeOf(entry.path()), entry.is_directory() ? 0700u : 0600u) << entry.path();
  EXPECT_EQ(files().size(), 2u);
}

TEST_F(BlobCacheTest, writesAndRemovesNothingThroughALink) {
  const fs::path victim = folder_ / "victim", first = toHex(refOf(1, 100).digest);
  fs::create_directories(victim / first.string().substr(0, 2));
  std::ofstream(victim / first.string().substr(0, 2) / first) << "mine";
  for (int i = 0; i < 100; ++i) std::ofstream(victim / std::to_string(i)) << std::string(50'000, 'x');
  fs::create_directory(folder_ / "cache");
  fs::create_directory_symlink(victim, folder_ / "cache" / "blobs");
  const size_t before = folder_.contents().size();
  EXPECT_FALSE(cache_.find(refOf(1, 100)));
  keep(2, 20'000);
  cache_.trim();
  EXPECT_EQ(folder_.contents().size(), before);
}

TEST_F(BlobCacheTest, isNotPreparedBehindALinkOfAnotherUser) {
  const fs::path link = test::makeStickyFolder(folder_ / "sticky") / "link";
  fs::create_directory(folder_ / "mine");
  fs::create_directory_symlink(folder_ / "mine", link);
  EXPECT_NO_THROW(prepareCacheFolder(link));
  if (!test::giveToStranger(link)) GTEST_SKIP() << "needs root";
  for (const fs::path& name : {link, link / "", link / "below"})
    EXPECT_THROW(prepareCacheFolder(name), Error) << name;
  EXPECT_TRUE(fs::is_empty(folder_ / "mine"));
}

TEST_F(BlobCacheTest, leavesTheWordsForAnotherFolderToTheProgram) {
  const auto refusal = [](const fs::path& folder) {
    try {
      prepareCacheFolder(folder);
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find(';'), std::string::npos) << error.what();
      return error.remedy();
    }
    return Remedy::kNone;
  };
  std::ofstream(folder_ / "file") << "not a folder";
  EXPECT_EQ(refusal(folder_ / "file"), Remedy::kForeignCacheFolder);
  EXPECT_EQ(refusal("/proc/nope"), Remedy::kCacheFolder);
  EXPECT_EQ(refusal("/proc"), Remedy::kCacheFolder) << "not even root makes files there";
}

TEST_F(BlobCacheTest, keepsNothingInAFolderOfAnotherUser) {
  fs::create_directories(folder_ / "cache" / "blobs");
  if (!test::giveToStranger(folder_ / "cache" / "blobs")) GTEST_SKIP() << "needs root";
  keep(1, 100);
  EXPECT_TRUE(files().empty());
}

TEST_F(BlobCacheTest, writersOfOneBlobDoNotMix) {
  std::vector<std::thread> writers;
  for (int writer = 0; writer < 4; ++writer)
    writers.emplace_back([&] {
      BlobCache own(folder_ / "cache", kLimit);
      for (int round = 0; round < 50; ++round) {
        own.keep(refOf(1, 30'000), bytesOf(1, 30'000));
        EXPECT_EQ(own.find(refOf(1, 30'000)), bytesOf(1, 30'000));
      }
    });
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(files().size(), 1u);
}

TEST_F(BlobCacheTest, remembersWhichBuildOfAModelAServerHad) {
  const ServedModel model{{"host", 7400}, "model"};
  EXPECT_FALSE(cache_.summary(model));
  ModelSummary summary;
  summary.name = "model";
  summary.build_id = digestOf(bytesOf(1, 10));
  summary.root_page = refOf(1, 300);
  cache_.keepSummary(model, summary);
  EXPECT_EQ(cache_.summary(model), summary);
  EXPECT_FALSE(cache_.summary({{"host", 7401}, "model"}));
}

TEST_F(BlobCacheTest, ignoresADamagedSummary) {
  const ServedModel model{{"host", 7400}, "model"};
  ModelSummary summary;
  summary.name = "model";
  summary.root_page = refOf(1, 300);
  cache_.keepSummary(model, summary);
  const fs::path file = files().front();
  for (std::streamoff at = 0; at < static_cast<std::streamoff>(fs::file_size(file)); ++at) {
    std::fstream changed(file, std::ios::in | std::ios::out | std::ios::binary);
    changed.seekg(at);
    const char byte = static_cast<char>(changed.get());
    changed.seekp(at).put(static_cast<char>(byte ^ 4)).flush();
    EXPECT_FALSE(cache_.summary(model)) << at;
    changed.seekp(at).put(byte);
  }
  ASSERT_TRUE(cache_.summary(model));
  for (uintmax_t size = fs::file_size(file); size-- > 0;) {
    fs::resize_file(file, size);
    EXPECT_FALSE(cache_.summary(model));
  }
}

}  // namespace
}  // namespace lode::stream
