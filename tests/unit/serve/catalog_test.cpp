#include "server/serve/session/catalog.h"

#include <array>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "common/error.h"
#include "proto/limits.h"
#include "tests/unit/serve/small_store.h"

namespace lode::serve {
namespace {

namespace fs = std::filesystem;
using test::WorkFolder;
using test::writeSmallStore;

class CatalogTest : public testing::Test {
 protected:
  std::shared_ptr<const Catalog> open(const std::vector<fs::path>& stores) {
    return openCatalog(stores, options_);
  }
  std::shared_ptr<const Catalog> reopen(const Catalog& before) {
    return reopenCatalog(before, std::vector{folder_.path()}, options_, skipped_);
  }
  std::string errorOf(const std::vector<fs::path>& stores) {
    try {
      open(stores);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
  fs::path store(const std::string& name) const { return folder_.path() / (name + ".lode"); }
  /// Renames a new store into place, as a build does.
  void replace(const std::string& name, uint32_t seed) {
    writeSmallStore(folder_.path() / "new.tmp", seed);
    fs::rename(folder_.path() / "new.tmp", store(name));
  }

  WorkFolder folder_;
  std::vector<SkippedStore> skipped_;
  std::vector<std::string> reports_;
  std::vector<StoreFault> faults_;
  BlobReaderOptions options_{.report = [this](StoreFault fault, std::string_view line) {
    faults_.push_back(fault);
    reports_.emplace_back(line);
  }};
};

TEST_F(CatalogTest, offersTheStoresOfFoldersAndFilesByName) {
  fs::create_directory(folder_.path() / "sub");
  writeSmallStore(folder_.path() / "sub" / "b.lode", 1);
  writeSmallStore(folder_.path() / "sub" / "a.lode", 2);
  const ModelSummary c = writeSmallStore(store("c"), 3);
  const auto catalog = open({store("c"), folder_.path() / "sub"});
  ASSERT_EQ(catalog->models().size(), 3u);
  EXPECT_EQ(catalog->models()[0]->summary.name, "a");
  EXPECT_EQ(catalog->models()[1]->summary.name, "b");
  EXPECT_EQ(catalog->find("c")->summary, c);
  EXPECT_EQ(catalog->find("d"), nullptr);
}

TEST_F(CatalogTest, offersEachBlobsSizeAndTheRootsCoarsestLod) {
  writeSmallStore(store("a"));
  const auto model = open({store("a")})->find("a");
  const store::Reader reader(store("a"));
  EXPECT_EQ(model->coarsest_blob, reader.find(kRootKey)->lods.back().payload.number);
  EXPECT_EQ(model->blobBytes(0), 0u);
  EXPECT_EQ(model->blobBytes(reader.blobCount() + 1), 0u);
  for (uint32_t blob = 1; blob <= reader.blobCount(); ++blob)
    EXPECT_EQ(model->blobBytes(blob), reader.blob(blob).bytes);
}

TEST_F(CatalogTest, aFileNamedTwiceIsOneModel) {
  writeSmallStore(store("a"));
  EXPECT_EQ(open({store("a"), store("a")})->models().size(), 1u);
}

TEST_F(CatalogTest, aFileNamedInTwoWaysIsOneModel) {
  writeSmallStore(store("a"));
  fs::create_directory(folder_.path() / "sub");
  fs::create_symlink(store("a"), folder_.path() / "sub" / "a.lode");
  EXPECT_EQ(open({store("a"), folder_.path() / "." / "a.lode", folder_.path() / "sub"})->models().size(), 1u);
}

TEST_F(CatalogTest, refusesTwoModelsOfOneName) {
  fs::create_directory(folder_.path() / "sub");
  writeSmallStore(store("a"), 1);
  writeSmallStore(folder_.path() / "sub" / "a.lode", 2);
  EXPECT_NE(errorOf({store("a"), folder_.path() / "sub"}).find("rename one"), std::string::npos);
}

TEST_F(CatalogTest, refusesAFolderWithoutStores) {
  EXPECT_NE(errorOf({folder_.path()}).find("lodestreamd build"), std::string::npos);
}

TEST_F(CatalogTest, refusesAMissingStore) {
  EXPECT_NE(errorOf({store("none")}).find("none.lode"), std::string::npos);
}

TEST_F(CatalogTest, refusesAnInvalidModelName) {
  writeSmallStore(store("a"));
  fs::rename(store("a"), folder_.path() / "a\nb.lode");
  EXPECT_NE(errorOf({folder_.path()}).find("UTF-8"), std::string::npos);
}

TEST_F(CatalogTest, refusesMoreModelsThanAListHolds) {
  const fs::path folder = folder_.path() / "many";
  fs::create_directory(folder);
  writeSmallStore(folder_.path() / "one.lode");
  for (uint32_t i = 0; i <= proto::kMaxListedModels; ++i)
    fs::create_hard_link(folder_.path() / "one.lode", folder / (std::to_string(i) + ".lode"));
  EXPECT_NE(errorOf({folder}).find(std::to_string(proto::kMaxListedModels)), std::string::npos);
}

TEST_F(CatalogTest, refusesNamesThatDoNotFitIntoOneAnswer) {
  const fs::path folder = folder_.path() / "many";
  fs::create_directory(folder);
  writeSmallStore(folder_.path() / "one.lode");
  for (uint32_t i = 0; i < proto::kMaxListedModels; ++i)
    fs::create_hard_link(folder_.path() / "one.lode",
                         folder / (std::string(200, 'x') + std::to_string(i) + ".lode"));
  EXPECT_NE(errorOf({folder}).find("shorten them"), std::string::npos) << errorOf({folder});
}

TEST_F(CatalogTest, refusesAPipe) {
  ASSERT_EQ(::mkfifo(store("a").c_str(), 0600), 0);
  EXPECT_NE(errorOf({store("a")}).find("not a regular file"), std::string::npos);
}

TEST_F(CatalogTest, offersNothingFromAnEmptiedFolderAfterAReload) {
  writeSmallStore(store("a"));
  const auto before = open({folder_.path()});
  fs::remove(store("a"));
  EXPECT_TRUE(reopen(*before)->models().empty());
}

TEST_F(CatalogTest, keepsUnchangedAndTakesNewStoresOnAReload) {
  writeSmallStore(store("a"), 1);
  writeSmallStore(store("b"), 2);
  writeSmallStore(store("c"), 3);
  const auto before = open({folder_.path()});
  replace("b", 4);
  fs::remove(store("c"));
  writeSmallStore(store("d"), 5);
  const auto after = reopen(*before);
  EXPECT_EQ(after->find("a"), before->find("a"));
  EXPECT_NE(after->find("b")->summary.build_id, before->find("b")->summary.build_id);
  EXPECT_EQ(after->find("c"), nullptr);
  EXPECT_NE(after->find("d"), nullptr);
  EXPECT_TRUE(reports_.empty());
}

TEST_F(CatalogTest, skipsAnInvalidStoreOnAReloadWithTheSameReason) {
  writeSmallStore(store("a"), 1);
  const auto before = open({folder_.path()});
  std::ofstream(store("junk")) << "junk\n";
  const std::string reason = errorOf({store("junk")});
  reopen(*before);
  ASSERT_EQ(skipped_.size(), 1u);
  EXPECT_EQ(skipped_[0].model, "junk");
  ASSERT_EQ(reports_.size(), 1u);
  EXPECT_NE(reason.find("is not a store"), std::string::npos) << reason;
  EXPECT_NE(reports_[0].find(reason.substr(reason.find("junk.lode"))), std::string::npos) << reports_[0];
  EXPECT_EQ(reports_[0].find(folder_.path().string()), std::string::npos) << "no path in the log";
}

TEST_F(CatalogTest, skipsAnInvalidStoreOfAFolderAndNamesTheReason) {
  writeSmallStore(store("a"), 1);
  std::ofstream(store("junk")) << "junk\n";
  writeSmallStore(store("cut"), 2);
  fs::resize_file(store("cut"), 5000);
  std::ofstream(store("empty"));
  fs::create_directory(store("folder"));
  fs::create_symlink("nowhere", store("link"));
  const auto catalog = openCatalog(std::vector{folder_.path()}, options_, &skipped_);
  ASSERT_EQ(catalog->models().size(), 1u);
  EXPECT_EQ(catalog->models()[0]->summary.name, "a");
  ASSERT_EQ(skipped_.size(), 5u);
  ASSERT_EQ(reports_.size(), 5u);
  const std::array expected{"cut", "empty", "folder", "junk", "link"};
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(skipped_[i].model, expected[i]);
    EXPECT_EQ(skipped_[i].why.find(std::string(expected[i]) + ".lode: "), 0u) << skipped_[i].why;
    EXPECT_NE(reports_[i].find(skipped_[i].why), std::string::npos) << reports_[i];
    EXPECT_NE(reports_[i].find("the model is not served"), std::string::npos) << reports_[i];
  }
  EXPECT_EQ(faults_[0], StoreFault::kDamaged);
  EXPECT_EQ(faults_[4], StoreFault::kUnreadable);
}

TEST_F(CatalogTest, refusesAFolderOfWhichNoStoreCanBeOpened) {
  std::ofstream(store("junk")) << "junk\n";
  EXPECT_THROW(openCatalog(std::vector{folder_.path()}, options_, &skipped_), Error);
}

TEST_F(CatalogTest, refusesAnInvalidNamedFileBesideValidOnes) {
  writeSmallStore(store("a"), 1);
  std::ofstream(store("junk")) << "junk\n";
  EXPECT_THROW(openCatalog(std::vector{store("a"), store("junk")}, options_, &skipped_), Error);
}

TEST_F(CatalogTest, refusesAFolderWithAnInvalidStoreIfStrict) {
  writeSmallStore(store("a"), 1);
  std::ofstream(store("junk")) << "junk\n";
  EXPECT_NE(errorOf({folder_.path()}).find("junk.lode"), std::string::npos);
}

TEST_F(CatalogTest, keepsTheOldStoreIfTheNewOneIsDamagedOnAReload) {
  writeSmallStore(store("a"), 1);
  const auto before = open({folder_.path()});
  replace("a", 2);
  fs::resize_file(store("a"), 5000);
  const auto after = reopen(*before);
  EXPECT_EQ(after->find("a"), before->find("a"));
  ASSERT_EQ(reports_.size(), 1u);
  EXPECT_EQ(reports_[0].find(folder_.path().string()), std::string::npos) << "no path in the log";
}

TEST_F(CatalogTest, aRemovedModelLivesAsLongAsItIsOpen) {
  const ModelSummary summary = writeSmallStore(store("a"), 1);
  writeSmallStore(store("b"), 1);
  auto before = open({folder_.path()});
  const auto model = before->find("a");
  fs::remove(store("a"));
  before = reopen(*before);
  std::vector<std::byte> bytes(summary.root_page.bytes);
  EXPECT_EQ(model->blobs->readHot({summary.root_page.number, 0, summary.root_page.bytes}, bytes),
            ReadResult::kDone);
}

}  // namespace
}  // namespace lode::serve
