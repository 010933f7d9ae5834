#include "server/serve/model_set.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "common/error.h"
#include "proto/limits.h"
#include "tests/unit/serve/small_store.h"

namespace lode::serve {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;
using test::writeSmallStore;

class ModelSetTest : public testing::Test {
 protected:
  ModelSet set(const std::vector<fs::path>& stores) {
    return ModelSet(stores, [this](std::string_view line) { log_.emplace_back(line); });
  }
  std::string errorOf(const std::vector<fs::path>& stores) {
    try {
      set(stores);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
  /// The whole blob as one chunk: the files are ours, so the limit of a chunk is none here.
  static Chunk whole(const ModelSet& models, uint32_t model, uint32_t blob) {
    const uint32_t bytes = models.offered()[model].blobBytes(blob);
    return {model, blob, bytes, 0, {1, bytes, 0}};
  }

  TemporaryFolder folder_;
  std::vector<std::string> log_;
};

TEST_F(ModelSetTest, offersTheStoresOfFoldersAndFilesByName) {
  fs::create_directory(folder_.path() / "sub");
  writeSmallStore(folder_.path() / "sub" / "b.lode", 1);
  writeSmallStore(folder_.path() / "sub" / "a.lode", 2);
  const ModelSummary c = writeSmallStore(folder_.path() / "c.lode", 3);
  const ModelSet models = set({folder_.path() / "c.lode", folder_.path() / "sub"});
  ASSERT_EQ(models.offered().size(), 3u);
  EXPECT_EQ(models.offered()[0].summary.name, "a");
  EXPECT_EQ(models.offered()[1].summary.name, "b");
  EXPECT_EQ(models.offered()[2].summary, c);
}

TEST_F(ModelSetTest, offersEachBlobsSizeAndTheRootsCoarsestRung) {
  writeSmallStore(folder_.path() / "a.lode");
  const ModelSet models = set({folder_.path() / "a.lode"});
  const store::Reader reader(folder_.path() / "a.lode");
  const OfferedModel& model = models.offered()[0];
  EXPECT_EQ(model.coarsest_blob, reader.find(kRootKey)->rungs.back().payload.number);
  EXPECT_EQ(model.blobBytes(0), 0u);
  EXPECT_EQ(model.blobBytes(reader.blobCount() + 1), 0u);
  for (uint32_t blob = 1; blob <= reader.blobCount(); ++blob)
    EXPECT_EQ(model.blobBytes(blob), reader.blob(blob).bytes);
}

TEST_F(ModelSetTest, aFileNamedTwiceIsOneModel) {
  writeSmallStore(folder_.path() / "a.lode");
  EXPECT_EQ(set({folder_.path() / "a.lode", folder_.path() / "a.lode"}).offered().size(), 1u);
}

TEST_F(ModelSetTest, refusesTwoModelsOfOneName) {
  fs::create_directory(folder_.path() / "sub");
  writeSmallStore(folder_.path() / "a.lode", 1);
  writeSmallStore(folder_.path() / "sub" / "a.lode", 2);
  EXPECT_NE(errorOf({folder_.path() / "a.lode", folder_.path() / "sub"}).find("rename one"),
            std::string::npos);
}

TEST_F(ModelSetTest, refusesAFolderWithoutStores) {
  EXPECT_NE(errorOf({folder_.path()}).find("lodestreamd build"), std::string::npos);
}

TEST_F(ModelSetTest, refusesAStoreThatIsNotThere) {
  EXPECT_NE(errorOf({folder_.path() / "none.lode"}).find("none.lode"), std::string::npos);
}

TEST_F(ModelSetTest, refusesANameThatCannotBeSent) {
  writeSmallStore(folder_.path() / "a.lode");
  fs::rename(folder_.path() / "a.lode", folder_.path() / "a\nb.lode");
  EXPECT_NE(errorOf({folder_.path()}).find("UTF-8"), std::string::npos);
}

TEST_F(ModelSetTest, refusesMoreModelsThanAListHolds) {
  const fs::path folder = folder_.path() / "many";
  fs::create_directory(folder);
  writeSmallStore(folder_.path() / "one.lode");
  for (uint32_t i = 0; i <= proto::kMaxListedModels; ++i)
    fs::create_hard_link(folder_.path() / "one.lode", folder / (std::to_string(i) + ".lode"));
  EXPECT_NE(errorOf({folder}).find(std::to_string(proto::kMaxListedModels)), std::string::npos);
}

TEST_F(ModelSetTest, aBlobIsCheckedWhenItIsFirstReadAndHotAfterwards) {
  writeSmallStore(folder_.path() / "a.lode");
  const ModelSet models = set({folder_.path()});
  const store::Reader reader(folder_.path() / "a.lode");
  const Chunk chunk = whole(models, 0, 2);
  std::vector<std::byte> bytes(chunk.bytes);
  EXPECT_EQ(models.readHot(chunk, bytes), ReadResult::kCold);
  EXPECT_EQ(models.readCold(chunk, bytes), ReadResult::kDone);
  EXPECT_EQ(bytes, reader.readBlob(2));
  std::fill(bytes.begin(), bytes.end(), std::byte{0});
  const ReadResult again = models.readHot(chunk, bytes);
  if (again == ReadResult::kCold) GTEST_SKIP() << "this file system cannot say what is in the page cache";
  EXPECT_EQ(again, ReadResult::kDone);
  EXPECT_EQ(bytes, reader.readBlob(2));
}

TEST_F(ModelSetTest, aChunkIsThePartThatItsOffsetNames) {
  writeSmallStore(folder_.path() / "a.lode");
  const ModelSet models = set({folder_.path()});
  const std::vector<std::byte> blob = store::Reader(folder_.path() / "a.lode").readBlob(1);
  const Chunk chunk{0, 1, 500, 0, {1, static_cast<uint32_t>(blob.size()), 700}};
  const std::vector<std::byte> expected(blob.begin() + 700, blob.begin() + 1200);
  for (int time = 0; time < 2; ++time) {  // the first is checked in whole, the second read alone
    std::vector<std::byte> bytes(500);
    EXPECT_EQ(models.readCold(chunk, bytes), ReadResult::kDone);
    EXPECT_EQ(bytes, expected);
  }
}

TEST_F(ModelSetTest, aDamagedBlobIsFoundAndStaysRefused) {
  const fs::path path = folder_.path() / "a.lode";
  writeSmallStore(path);
  const ModelSet models = set({path});
  test::damage(path, store::Reader(path).blob(2).offset + 5000);
  std::vector<std::byte> bytes(9000);
  const Chunk chunk{0, 2, 100, 0, {1, 9000, 0}};
  EXPECT_EQ(models.readCold(chunk, bytes), ReadResult::kDamaged);
  EXPECT_EQ(models.readHot(chunk, bytes), ReadResult::kDamaged);
  ASSERT_EQ(log_.size(), 1u);
  EXPECT_NE(log_[0].find(path.string()), std::string::npos);
}

TEST_F(ModelSetTest, aFileThatWasTruncatedIsDamaged) {
  const fs::path path = folder_.path() / "a.lode";
  writeSmallStore(path);
  const ModelSet models = set({path});
  const Chunk chunk = whole(models, 0, 3);
  std::vector<std::byte> bytes(chunk.bytes);
  ASSERT_EQ(models.readCold(chunk, bytes), ReadResult::kDone);
  fs::resize_file(path, 1000);
  EXPECT_EQ(models.readHot(chunk, bytes), ReadResult::kCold);
  EXPECT_EQ(models.readCold(chunk, bytes), ReadResult::kDamaged);
  EXPECT_EQ(models.readCold(whole(models, 0, 4), bytes), ReadResult::kDamaged);
}

}  // namespace
}  // namespace lode::serve
