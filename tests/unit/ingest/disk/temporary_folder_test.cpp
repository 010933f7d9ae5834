#include "server/ingest/disk/temporary_folder.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode::ingest {
namespace {

namespace fs = std::filesystem;

class OwnFolder : public testing::Test {
 protected:
  OwnFolder() : parent_(testing::TempDir()) {}

  fs::path path() const { return parent_.path() / "own"; }

  const TemporaryFolder parent_;
  const FolderUse use_{"the test", "name another"};
};

TEST_F(OwnFolder, isMadeForThisUserAlone) {
  makeOwnFolder(path(), use_);
  EXPECT_EQ(fs::status(path()).permissions() & fs::perms::all, fs::perms::owner_all);
}

TEST_F(OwnFolder, mayBeThereAlready) {
  makeOwnFolder(path(), use_);
  EXPECT_NO_THROW(makeOwnFolder(path(), use_));
}

TEST_F(OwnFolder, isRefusedWhereALinkStandsInItsPlace) {
  fs::create_directory(parent_.path() / "elsewhere");
  fs::create_directory_symlink(parent_.path() / "elsewhere", path());
  EXPECT_THROW(makeOwnFolder(path(), use_), Error);
}

TEST_F(OwnFolder, isRefusedWhereALinkLeadsNowhere) {
  fs::create_directory_symlink(parent_.path() / "nowhere", path());
  EXPECT_THROW(makeOwnFolder(path(), use_), Error);
}

TEST_F(OwnFolder, isRefusedWhereOthersMayWrite) {
  fs::create_directory(path());
  fs::permissions(path(), fs::perms::all);
  EXPECT_THROW(makeOwnFolder(path(), use_), Error);
}

}  // namespace
}  // namespace lode::ingest
