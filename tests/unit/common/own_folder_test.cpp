#include "common/io/own_folder.h"

#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/support/bytes.h"
#include "tests/support/strangers.h"
#include "tests/support/work_folder.h"

namespace lode {
namespace {

namespace fs = std::filesystem;

class OwnFolder : public testing::Test {
 protected:
  bool isRefused(const fs::path& path) const {
    try {
      makeOwnFolder(path, use_);
      return false;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kIo);
      EXPECT_NE(std::string(error.what()).find("name another"), std::string::npos) << error.what();
      return true;
    }
  }

  const test::WorkFolder parent_;
  const fs::path path_ = parent_ / "own";
  const FolderUse use_{"the test", "name another"};
};

TEST_F(OwnFolder, isMadeForThisUserAlone) {
  makeOwnFolder(path_, use_);
  EXPECT_EQ(test::modeOf(path_), 0700u);
  EXPECT_TRUE(isOwnFolder(path_));
}

TEST_F(OwnFolder, isMadeWithTheFoldersAboveIt) {
  makeOwnFolders(path_ / "a/b/", use_);
  for (const char* below : {"", "a", "a/b"}) EXPECT_EQ(test::modeOf(path_ / below), 0700u) << below;
}

TEST_F(OwnFolder, isClosedToOthersIfItExists) {
  fs::create_directory(path_);
  fs::permissions(path_, fs::perms(0755));
  makeOwnFolder(path_, use_);
  EXPECT_EQ(test::modeOf(path_), 0700u);
}

TEST_F(OwnFolder, isRefusedWhereALinkStandsInItsPlace) {
  fs::create_directory(parent_ / "elsewhere");
  fs::create_directory_symlink(parent_ / "elsewhere", path_);
  EXPECT_TRUE(isRefused(path_));
  EXPECT_TRUE(isRefused(path_ / ""));  // system calls follow a link before a slash
  EXPECT_FALSE(isOwnFolder(path_));
  EXPECT_THROW(refuseForeignFolder(path_, use_), Error);
}

TEST_F(OwnFolder, isRefusedWhereALinkLeadsNowhere) {
  fs::create_directory_symlink(parent_ / "nowhere", path_);
  EXPECT_TRUE(isRefused(path_));
}

TEST_F(OwnFolder, isRefusedWhereAFileStands) {
  std::ofstream(path_) << "a file";
  EXPECT_TRUE(isRefused(path_));
}

TEST_F(OwnFolder, isRefusedWhereOthersMayWrite) {
  fs::create_directory(path_);
  for (const mode_t mode : {0777u, 0770u, 0702u}) {
    fs::permissions(path_, fs::perms(mode));
    EXPECT_TRUE(isRefused(path_)) << mode;
    EXPECT_EQ(test::modeOf(path_), mode) << "it is left as it was";
  }
}

TEST_F(OwnFolder, isRefusedIfItBelongsToAnotherUser) {
  fs::create_directory(path_);
  if (!test::giveToStranger(path_)) GTEST_SKIP() << "needs root";
  EXPECT_TRUE(isRefused(path_));
  EXPECT_THROW(refuseForeignFolder(path_, use_), Error);
}

TEST_F(OwnFolder, isNotForeignIfMissing) { EXPECT_NO_THROW(refuseForeignFolder(path_, use_)); }

TEST_F(OwnFolder, hasFilesForThisUserAlone) {
  EXPECT_TRUE(writeOwnFile(parent_ / "file", test::bytesOf("text")));
  EXPECT_EQ(test::modeOf(parent_ / "file"), 0600u);
  EXPECT_EQ(test::readBytes(parent_ / "file"), "text");
  EXPECT_EQ(parent_.contents().size(), 1u);
}

TEST_F(OwnFolder, hasFilesThatReplaceALinkAndNotItsTarget) {
  std::ofstream(parent_ / "target") << "old";
  fs::create_symlink("target", parent_ / "file");
  EXPECT_TRUE(writeOwnFile(parent_ / "file", test::bytesOf("new")));
  EXPECT_EQ(test::readBytes(parent_ / "target"), "old");
  EXPECT_FALSE(fs::is_symlink(parent_ / "file"));
}

TEST_F(OwnFolder, doesNotWriteThroughALinkWithATemporaryName) {
  std::ofstream(parent_ / "target") << "old";
  for (int next = 0; next < 200; ++next)  // names of this process's next temporary files
    fs::create_symlink("target",
                       parent_ / (kNewFile + std::to_string(::getpid()) + "-" + std::to_string(next)));
  EXPECT_TRUE(writeOwnFile(parent_ / "file", test::bytesOf("new")));
  EXPECT_EQ(test::readBytes(parent_ / "target"), "old");
  EXPECT_EQ(test::readBytes(parent_ / "file"), "new");
}

TEST_F(OwnFolder, reportsAFileThatCannotBeWritten) {
  EXPECT_FALSE(writeOwnFile(parent_ / "missing/file", test::bytesOf("text")));
  fs::create_directories(parent_ / "folder/with");
  EXPECT_FALSE(writeOwnFile(parent_ / "folder", test::bytesOf("text")));
  EXPECT_EQ(parent_.contents(), (std::vector<std::string>{"folder", "folder/with"}));
}

TEST(SecretFile, isOpenToOthersByItsModeAndOwner) {
  const test::WorkFolder folder;
  const fs::path file = folder / "secret";
  std::ofstream(file) << "secret";
  for (const mode_t mode : {0600u, 0400u, 0700u}) {
    fs::permissions(file, fs::perms(mode));
    EXPECT_FALSE(isOpenToOthers(file)) << mode;
  }
  for (const mode_t mode : {0644u, 0640u, 0620u, 0602u, 0604u, 0666u}) {
    fs::permissions(file, fs::perms(mode));
    EXPECT_TRUE(isOpenToOthers(file)) << mode;
  }
  fs::permissions(file, fs::perms(0600));
  EXPECT_FALSE(isOpenToOthers(folder / "missing"));
  EXPECT_FALSE(isOpenToOthers("/dev/null"));
  const bool is_given = test::giveToStranger(file);
  EXPECT_EQ(isOpenToOthers(file), is_given);
}

}  // namespace
}  // namespace lode
