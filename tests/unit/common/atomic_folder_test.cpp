#include "common/io/atomic_folder.h"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "common/error.h"
#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"

namespace lode {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

class AtomicFolders : public testing::Test {
 protected:
  /// Returns the message of the error for a path; empty if there is no error.
  static std::string refusal(const fs::path& path) {
    try {
      AtomicFolder folder(path);
      folder.commit();
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }

  test::WorkFolder work_;
};

TEST_F(AtomicFolders, appearWhenTheyAreComplete) {
  AtomicFolder folder(work_ / "new");
  folder.makeFolder("a");
  folder.write("a/b", test::bytesOf("content"));
  folder.write("c", {});
  EXPECT_FALSE(fs::exists(work_ / "new"));
  folder.commit();
  EXPECT_EQ(work_.contents(), (Names{"new", "new/a", "new/a/b", "new/c"}));
  EXPECT_EQ(test::readBytes(work_ / "new/a/b"), "content");
}

TEST_F(AtomicFolders, leaveNothingWithoutACommit) {
  {
    AtomicFolder folder(work_ / "new");
    folder.makeFolder("a");
    folder.write("a/b", test::bytesOf("content"));
  }
  EXPECT_EQ(work_.contents(), Names{});
}

TEST_F(AtomicFolders, leaveNothingAfterASignal) {
  EXPECT_EXIT(
      {
        AtomicFolder folder(work_ / "new");
        folder.makeFolder("a");
        folder.write("a/b", test::bytesOf("content"));
        std::raise(SIGTERM);
      },
      testing::KilledBySignal(SIGTERM), "unfinished output is removed");
  EXPECT_EQ(work_.contents(), Names{});
}

TEST_F(AtomicFolders, takeThePlaceOfAnEmptyFolder) {
  fs::create_directory(work_ / "empty");
  EXPECT_EQ(refusal(work_ / "empty"), "");
  EXPECT_EQ(refusal((work_ / "empty").string() + "/"), "");
}

TEST_F(AtomicFolders, takeThePlaceOfTheFolderBehindALink) {
  fs::create_directory(work_ / "empty");
  fs::create_symlink("empty", work_ / "link");
  AtomicFolder folder(work_ / "link");
  folder.write("a", {});
  folder.commit();
  EXPECT_TRUE(fs::is_symlink(work_ / "link"));
  EXPECT_TRUE(fs::exists(work_ / "empty/a"));
}

TEST_F(AtomicFolders, refuseAFolderWithFiles) {
  fs::create_directory(work_ / "full");
  std::ofstream(work_ / "full/file") << "x";
  EXPECT_EQ(refusal(work_ / "full"),
            (work_ / "full").string() +
                " exists and is not an empty folder; name a new folder, or remove this one");
  EXPECT_EQ(work_.contents(), (Names{"full", "full/file"}));
}

TEST_F(AtomicFolders, refuseAFile) {
  std::ofstream(work_ / "file") << "x";
  EXPECT_NE(refusal(work_ / "file").find("is not an empty folder"), std::string::npos);
  EXPECT_EQ(test::readBytes(work_ / "file"), "x");
}

TEST_F(AtomicFolders, refuseAFolderThatWasFilledMeanwhile) {
  AtomicFolder folder(work_ / "new");
  fs::create_directory(work_ / "new");
  std::ofstream(work_ / "new/file") << "x";
  EXPECT_THROW(folder.commit(), Error);
  EXPECT_TRUE(fs::exists(work_ / "new/file"));
}

TEST_F(AtomicFolders, nameTheFolderThatCannotBeCreated) {
  const std::string message = refusal(work_ / "missing/new");
  EXPECT_EQ(message.rfind("cannot create folder " + (work_ / "missing/new").string(), 0), 0u) << message;
  EXPECT_NE(message.find("No such file"), std::string::npos) << message;
  const std::string refused = refusal("/sys/new");  // not even root can create folders in /sys
  EXPECT_EQ(refused.rfind("cannot create folder /sys/new", 0), 0u) << refused;
  EXPECT_EQ(refused.find("No such file"), std::string::npos) << refused;
}

TEST_F(AtomicFolders, refuseAMountPoint) {
  EXPECT_EQ(refusal("/proc"), "/proc is a mount point; name a new folder in it");
}

TEST_F(AtomicFolders, canBeReadByWebServers) {
  const mode_t before = ::umask(022);
  AtomicFolder folder(work_ / "new");
  folder.write("a", {});
  folder.commit();
  ::umask(before);
  EXPECT_EQ(fs::status(work_ / "new").permissions(), fs::perms(0755));
  EXPECT_EQ(fs::status(work_ / "new/a").permissions(), fs::perms(0644));
}

TEST_F(AtomicFolders, refuseASecondFileOfTheSameName) {
  const AtomicFolder folder(work_ / "new");
  folder.write("a", {});
  EXPECT_THROW(folder.write("a", {}), Error);
}

}  // namespace
}  // namespace lode
