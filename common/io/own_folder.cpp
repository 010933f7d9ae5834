#include "common/io/own_folder.h"

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"
#include "common/io/file_io.h"

namespace lode {
namespace {

constexpr mode_t kOwnerOnly = S_IRWXU;

[[noreturn]] void failToMake(const std::filesystem::path& path, const FolderUse& use, int error) {
  throw Error(ErrorCode::kIo,
              std::string("cannot make a folder for ") + use.what + " in " + path.parent_path().string() +
                  ": " + std::strerror(error) + (use.remedy ? std::string("; ") + use.remedy : ""),
              use.if_not_made);
}

[[noreturn]] void refuse(const std::filesystem::path& path, const FolderUse& use) {
  throw Error(ErrorCode::kIo,
              path.string() + ": is not a folder that only you can write to" +
                  (use.remedy ? std::string("; remove it, or ") + use.remedy : ""),
              use.if_foreign);
}

bool isOwn(const struct stat& status) noexcept {
  return S_ISDIR(status.st_mode) && status.st_uid == ::geteuid() &&
         (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/// Removes trailing slashes, because system calls follow a link if a slash follows its name.
std::filesystem::path withoutSlash(const std::filesystem::path& path) {
  return path.has_filename() || !path.has_relative_path() ? path : path.parent_path();
}

void makeParents(const std::filesystem::path& path) {
  const std::filesystem::path parent = path.parent_path();
  if (parent.empty() || parent == path || ::access(parent.c_str(), F_OK) == 0) return;
  makeParents(parent);
  ::mkdir(parent.c_str(), kOwnerOnly);  // ignores a failure, which makeOwnFolder() reports
}

}  // namespace

bool isOwnFolder(const std::filesystem::path& path) noexcept {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 && isOwn(status);
}

void makeOwnFolder(const std::filesystem::path& asked, const FolderUse& use) {
  const std::filesystem::path path = withoutSlash(asked);
  if (::mkdir(path.c_str(), kOwnerOnly) == 0) return;
  if (errno != EEXIST) failToMake(path, use, errno);
  const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (folder < 0 && errno == ENOENT) return makeOwnFolder(path, use);  // another process removed the folder
  if (folder < 0) refuse(path, use);
  struct stat status {};
  const bool is_own = ::fstat(folder, &status) == 0 && isOwn(status);
  const bool is_closed =
      is_own && ((status.st_mode & ACCESSPERMS) == kOwnerOnly || ::fchmod(folder, kOwnerOnly) == 0);
  const int error = errno;
  ::close(folder);
  if (!is_own) refuse(path, use);
  if (!is_closed) failToMake(path, use, error);
}

void makeOwnFolders(const std::filesystem::path& asked, const FolderUse& use) {
  const std::filesystem::path path = withoutSlash(asked);
  makeParents(path);
  makeOwnFolder(path, use);
}

void refuseForeignFolder(const std::filesystem::path& asked, const FolderUse& use) {
  const std::filesystem::path path = withoutSlash(asked);
  struct stat status {};
  if (::lstat(path.c_str(), &status) == 0 && !isOwn(status)) refuse(path, use);
}

bool writeOwnFile(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  static std::atomic<uint64_t> serial{0};
  const std::filesystem::path temporary =
      path.parent_path() / (kNewFile + std::to_string(::getpid()) + "-" + std::to_string(++serial));
  constexpr int kFlags = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
  int file = ::open(temporary.c_str(), kFlags, S_IRUSR | S_IWUSR);
  if (file < 0 && errno == EEXIST && ::unlink(temporary.c_str()) == 0)  // left by a killed process
    file = ::open(temporary.c_str(), kFlags, S_IRUSR | S_IWUSR);
  if (file < 0) return false;
  bool is_written = append(file, bytes);
  is_written = ::close(file) == 0 && is_written;
  if (is_written && ::rename(temporary.c_str(), path.c_str()) == 0) return true;
  const int error = errno;
  ::unlink(temporary.c_str());
  errno = error;
  return false;
}

bool isOpenToOthers(const std::filesystem::path& file) noexcept {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_nlink == 0) return false;
  constexpr mode_t kOthers = S_IRWXG | S_IRWXO;
  if (status.st_uid == ::geteuid()) return (status.st_mode & kOthers) != 0;
  return status.st_uid != 0 || (status.st_mode & (kOthers & ~mode_t{S_IRGRP})) != 0;
}

}  // namespace lode
