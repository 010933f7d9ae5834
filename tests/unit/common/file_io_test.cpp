#include "common/io/file_io.h"

#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"
#include "tests/support/work_folder.h"

namespace lode {
namespace {

/// An open temporary file without a name.
class OpenFile {
 public:
  OpenFile() : file_(::open("/tmp", O_RDWR | O_TMPFILE | O_CLOEXEC, 0600)) {}
  ~OpenFile() { ::close(file_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int get() const { return file_; }

 private:
  int file_;
};

constexpr std::array<std::byte, 4> kBytes{std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}};

TEST(FileIo, refusesFoldersPipesAndDevicesWhereAFileIsWanted) {
  const test::WorkFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  std::filesystem::create_symlink("pipe", folder / "link");
  std::ofstream(folder / "file") << "text";
  for (const std::filesystem::path& path :
       {folder.path(), folder / "pipe", folder / "link", std::filesystem::path("/dev/zero")})
    EXPECT_THROW(refuseUnlessFile(path, "a file"), Error) << path;
  for (const char* name : {"file", "missing"})
    EXPECT_NO_THROW(refuseUnlessFile(folder / name, "a file")) << name;
}

TEST(FileIo, readsBackBytesAtAnOffset) {
  const OpenFile file;
  ASSERT_TRUE(writeAt(file.get(), 10, kBytes));
  std::array<std::byte, 4> bytes{};
  EXPECT_EQ(readAt(file.get(), 10, bytes), 4u);
  EXPECT_EQ(bytes, kBytes);
}

TEST(FileIo, returnsTheBytesReadBeforeTheEnd) {
  const OpenFile file;
  ASSERT_TRUE(writeAt(file.get(), 0, kBytes));
  std::array<std::byte, 4> bytes{};
  EXPECT_EQ(readAt(file.get(), 3, bytes), 1u);
  EXPECT_EQ(readAt(file.get(), 99, bytes), 0u);
}

TEST(FileIo, leavesTheReasonOfAFailureInErrno) {
  std::array<std::byte, 4> bytes{};
  EXPECT_FALSE(readAt(-1, 0, bytes));
  EXPECT_EQ(errno, EBADF);
  EXPECT_FALSE(writeAt(-1, 0, bytes));
  EXPECT_EQ(errno, EBADF);
}

TEST(FileIo, callsAFullDiskAndAFullQuotaTheSame) {
  EXPECT_EQ(fileErrorInWords(ENOSPC), "the disk is full; free some space");
  EXPECT_EQ(fileErrorInWords(EDQUOT), fileErrorInWords(ENOSPC));
  EXPECT_EQ(fileErrorInWords(EDQUOT, "choose another place"), "the disk is full; choose another place");
  EXPECT_EQ(fileErrorInWords(EACCES), "Permission denied");
}

}  // namespace
}  // namespace lode
