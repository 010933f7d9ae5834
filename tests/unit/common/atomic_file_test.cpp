#include "common/io/atomic_file.h"

#include <algorithm>
#include <fstream>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/error.h"
#include "tests/support/bytes.h"
#include "tests/support/strangers.h"
#include "tests/support/work_folder.h"

namespace lode {
namespace {

namespace fs = std::filesystem;

using test::bytesOf;

class AtomicFileTest : public testing::Test {
 protected:
  std::string content() const { return test::readBytes(target_); }
  size_t filesInFolder() const { return folder_.contents().size(); }

  test::WorkFolder folder_;
  const fs::path target_ = folder_ / "target";
};

TEST_F(AtomicFileTest, appearsUnderItsNameOnlyAtCommit) {
  AtomicFile file(target_);
  file.write(bytesOf("hello"));
  EXPECT_FALSE(fs::exists(target_));
  file.commit();
  EXPECT_EQ(content(), "hello");
  EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(AtomicFileTest, leavesNothingBehindWithoutCommit) {
  {
    AtomicFile file(target_);
    file.write(bytesOf(std::string(1 << 20, 'x')));
  }
  EXPECT_EQ(filesInFolder(), 0u);
}

TEST_F(AtomicFileTest, leavesTheOldFileWithoutCommit) {
  std::ofstream(target_) << "old";
  { AtomicFile(target_).write(bytesOf("new")); }
  EXPECT_EQ(content(), "old");
}

TEST_F(AtomicFileTest, replacesTheOldFile) {
  std::ofstream(target_) << "old and longer";
  AtomicFile file(target_);
  file.write(bytesOf("new"));
  file.commit();
  EXPECT_EQ(content(), "new");
}

TEST_F(AtomicFileTest, keepsTheOrderOfSmallAndLargeWrites) {
  std::string expected;
  AtomicFile file(target_);
  for (size_t i = 0; i < 60; ++i) {
    const std::string part(i % 7 == 0 ? 100000 * (i % 5) : i, static_cast<char>('a' + i % 26));
    file.write(bytesOf(part));
    expected += part;
    ASSERT_EQ(file.size(), expected.size());
  }
  file.commit();
  EXPECT_TRUE(content() == expected);
}

TEST_F(AtomicFileTest, overwritesEarlierBytes) {
  AtomicFile file(target_);
  file.write(bytesOf("0123456789"));
  file.writeAt(3, bytesOf("abc"));
  file.write(bytesOf("end"));
  EXPECT_EQ(file.size(), 13u);
  file.commit();
  EXPECT_EQ(content(), "012abc6789end");
}

TEST_F(AtomicFileTest, refusesToWriteOverMoreThanWasWritten) {
  AtomicFile file(target_);
  file.write(bytesOf("0123"));
  EXPECT_THROW(file.writeAt(2, bytesOf("abc")), Error);
  EXPECT_THROW(file.writeAt(UINT64_MAX, bytesOf("abc")), Error);
}

TEST_F(AtomicFileTest, twoWritersOfOneTargetDoNotMix) {
  AtomicFile first(target_), second(target_);
  first.write(bytesOf("first"));
  second.write(bytesOf("second"));
  first.commit();
  EXPECT_EQ(content(), "first");
  second.commit();
  EXPECT_EQ(content(), "second");
}

TEST_F(AtomicFileTest, transfersTheFileWhenMoved) {
  AtomicFile file(target_);
  file.write(bytesOf("a"));
  AtomicFile moved(std::move(file));
  moved.write(bytesOf("b"));
  moved.commit();
  EXPECT_EQ(content(), "ab");
}

TEST_F(AtomicFileTest, namesTheFileThatCannotBeCreated) {
  try {
    AtomicFile file(folder_ / "missing" / "target");
    FAIL() << "created a file in a folder that does not exist";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kIo);
    EXPECT_NE(std::string_view(error.what()).find("missing/target"), std::string_view::npos) << error.what();
  }
}

TEST_F(AtomicFileTest, leavesNothingBehindWhenTheRenameFails) {
  {
    AtomicFile file(target_);
    fs::create_directory(target_);
    EXPECT_THROW(file.commit(), Error);
  }
  EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(AtomicFileTest, namesTheTargetNotTheTemporaryFileInErrors) {
  const std::string name(250, 'x');  // the temporary file's name, which is longer, is too long
  try {
    AtomicFile file(folder_ / name);
    FAIL() << "made a temporary file of too long a name";
  } catch (const Error& error) {
    EXPECT_NE(std::string_view(error.what()).find(name + ": "), std::string_view::npos) << error.what();
  }
}

TEST_F(AtomicFileTest, replacesTheTargetOfALinkNotTheLink) {
  fs::create_directory(folder_ / "there");
  std::ofstream(folder_ / "there/file") << "old";
  fs::create_symlink("there/second", target_);
  fs::create_symlink("file", folder_ / "there/second");
  AtomicFile file(target_);
  file.write(bytesOf("new"));
  file.commit();
  EXPECT_TRUE(fs::is_symlink(target_));
  EXPECT_EQ(test::readBytes(folder_ / "there/file"), "new");
}

TEST_F(AtomicFileTest, createsTheMissingTargetOfALink) {
  fs::create_symlink("later", target_);
  AtomicFile file(target_);
  file.write(bytesOf("new"));
  file.commit();
  EXPECT_TRUE(fs::is_symlink(target_));
  EXPECT_EQ(test::readBytes(folder_ / "later"), "new");
}

TEST_F(AtomicFileTest, refusesALinkOfAnotherUserInAStickyFolder) {
  const fs::path sticky = test::makeStickyFolder(folder_ / "sticky"), victim = folder_ / "victim";
  fs::create_directory(folder_ / "folder");
  const std::vector<std::pair<const char*, fs::path>> links{{"to-file", victim},
                                                            {"to-nothing", folder_ / "later"},
                                                            {"to-device", "/dev/null"},
                                                            {"to-folder", folder_ / "folder"}};
  std::ofstream(victim) << "precious";
  for (const auto& [name, to] : links) {
    fs::create_symlink(to, sticky / name);
    if (!test::giveToStranger(sticky / name)) GTEST_SKIP() << "needs root";
  }
  fs::create_symlink("sticky/to-file", folder_ / "own-link");
  for (const fs::path& name : {sticky / "to-file", sticky / "to-nothing", sticky / "to-device",
                               sticky / "to-folder/file", folder_ / "own-link"}) {
    EXPECT_THROW(AtomicFile{name}, Error) << name;
  }
  EXPECT_EQ(test::readBytes(victim), "precious");
  EXPECT_FALSE(fs::exists(folder_ / "later"));
  EXPECT_TRUE(fs::is_empty(folder_ / "folder"));
}

TEST_F(AtomicFileTest, followsAnOwnLinkInAStickyFolderAndAForeignOneElsewhere) {
  fs::create_symlink(target_, test::makeStickyFolder(folder_ / "sticky") / "link");
  fs::create_symlink(target_, folder_ / "foreign");
  test::giveToStranger(folder_ / "foreign");
  for (const fs::path& name : {folder_ / "sticky/link", folder_ / "foreign"}) {
    AtomicFile file(name);
    file.write(bytesOf(name.string()));
    file.commit();
    EXPECT_EQ(content(), name);
  }
}

TEST_F(AtomicFileTest, replacesOnlyOwnRegularFilesUnderADerivedName) {
  const auto write = [this](const fs::path& name) {
    AtomicFile file(name, {}, OutputName::kDerived);
    file.write(bytesOf("new"));
    file.commit();
    EXPECT_EQ(test::readBytes(name), "new");
  };
  write(target_);
  write(target_);  // replaces a file of this user
  std::ofstream(folder_ / "victim") << "precious";
  fs::create_symlink("victim", folder_ / "link");
  fs::create_symlink("nothing", folder_ / "dangling");
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  fs::create_directory(folder_ / "folder");
  for (const char* name : {"link", "dangling", "pipe", "folder"})
    EXPECT_THROW(write(folder_ / name), Error) << name;
  EXPECT_EQ(test::readBytes(folder_ / "victim"), "precious");
  fs::create_directory_symlink("folder", folder_ / "own-way");
  write(folder_ / "own-way/file");
  if (!test::giveToStranger(folder_ / "victim")) GTEST_SKIP() << "needs root";
  EXPECT_THROW(write(folder_ / "victim"), Error);
}

TEST_F(AtomicFileTest, writesIntoAnExistingPipe) {
  ASSERT_EQ(::mkfifo(target_.c_str(), 0600), 0);
  const int reader = ::open(target_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  AtomicFile file(target_);
  file.write(bytesOf("through"));
  file.commit();
  std::string came(16, '\0');
  const ssize_t bytes = ::read(reader, came.data(), came.size());
  ::close(reader);
  ASSERT_EQ(bytes, 7);
  EXPECT_EQ(came.substr(0, 7), "through");
  EXPECT_TRUE(fs::is_fifo(target_));
  EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(AtomicFileTest, writesIntoADeviceBehindALink) {
  fs::create_symlink("/dev/null", target_);
  AtomicFile file(target_);
  file.write(bytesOf("nothing of it stays"));
  file.commit();
  EXPECT_TRUE(fs::is_symlink(target_));
}

TEST_F(AtomicFileTest, refusesToOverwriteBytesOfAPipe) {
  ASSERT_EQ(::mkfifo(target_.c_str(), 0600), 0);
  const int reader = ::open(target_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  AtomicFile file(target_);
  file.write(bytesOf("0123"));
  EXPECT_THROW(file.writeAt(0, bytesOf("ab")), Error);
  ::close(reader);
}

TEST_F(AtomicFileTest, refusesAnImpossibleTargetAtOnce) {
  fs::create_directory(target_);
  fs::create_symlink("circle", folder_ / "circle");
  for (const fs::path& name : {target_, fs::path(), folder_ / "missing/", folder_ / "circle"}) {
    EXPECT_THROW(AtomicFile{name}, Error) << name;
  }
  fs::remove(folder_ / "circle");
  EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(AtomicFileTest, respectsTheUmask) {
  const mode_t before = ::umask(027);
  AtomicFile file(target_);
  ::umask(before);
  file.commit();
  EXPECT_EQ(fs::status(target_).permissions(), fs::perms(0640));
}

// Fills a small file system, mounted in a namespace of a child process. Exit status: 0 if the error says that
// the disk is full, 1 if it does not, 77 if the system does not allow such namespaces.
int fillTinyDisk(const fs::path& folder) {
  const bool root = ::geteuid() == 0;
  if (::unshare(root ? CLONE_NEWNS : CLONE_NEWNS | CLONE_NEWUSER) != 0) return 77;
  if (::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return 77;
  if (::mount("tmpfs", folder.c_str(), "tmpfs", 0, "size=65536") != 0) return 77;
  try {
    AtomicFile file(folder / "target");
    file.write(bytesOf(std::string(1 << 20, 'x')));
    file.commit();
  } catch (const Error& error) {
    const std::string_view message = error.what();
    const bool nothing_left = fs::is_empty(folder);
    return error.code() == ErrorCode::kIo && nothing_left && message.find("disk is full") != message.npos ? 0
                                                                                                          : 1;
  }
  return 1;
}

TEST_F(AtomicFileTest, saysThatTheDiskIsFull) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) ::_exit(fillTinyDisk(folder_.path()));
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 77) GTEST_SKIP() << "no mount namespaces on this system";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace lode
