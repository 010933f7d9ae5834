#include "server/ingest/disk/build_folder.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <span>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/codec/blob.h"
#include "common/error.h"
#include "common/io/own_folder.h"

namespace lode::ingest {
namespace {

constexpr const char *kJournal = "journal", *kFiles = "files";

std::filesystem::path folderOf(const std::filesystem::path& output) {
  return output.has_parent_path() ? output.parent_path() : std::filesystem::path(".");
}

std::filesystem::path buildFolderOf(const std::filesystem::path& output) {
  return folderOf(output) / ("." + output.filename().string() + ".building");
}

void removeAll(const std::filesystem::path& path) noexcept {
  std::error_code ignored;
  std::filesystem::remove_all(path, ignored);
}

std::filesystem::path resolved(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::weakly_canonical(path, ignored);
}

void syncFolder(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0)
    throw Error(ErrorCode::kIo, "cannot open folder " + path.string() + ": " + std::strerror(errno));
  const int error = ::fsync(file) == 0 ? 0 : errno;
  ::close(file);
  // Some network file systems cannot sync a folder.
  if (error != 0 && error != EINVAL) {
    throw Error(ErrorCode::kIo, "cannot sync folder " + path.string() + ": " + std::strerror(error));
  }
}

}  // namespace

BuildFiles BuildFiles::of(const std::filesystem::path& output) {
  const std::filesystem::path folder = buildFolderOf(output);
  return {folder / kJournal, folder / kFiles};
}

BuildFolder::BuildFolder(const std::filesystem::path& output, const std::filesystem::path& temporary_parent)
    : output_(output),
      output_folder_(folderOf(output)),
      path_(buildFolderOf(output)),
      files_(filesIn(temporary_parent)) {
  lock();
}

BuildFolder::~BuildFolder() {
  if (!is_kept_) {
    removeAll(files_);
    ::unlink(store().c_str());
    ::unlink(journal().c_str());
    ::unlink((path_ / "lock").c_str());
    ::rmdir(path_.c_str());
  }
  ::close(lock_);
}

std::filesystem::path BuildFolder::filesIn(const std::filesystem::path& temporary_parent) const {
  const std::filesystem::path home = resolved(output_folder_);
  if (resolved(temporary_parent) == home) return path_ / kFiles;
  const std::string whole_name = (home / output_.filename()).string();
  char name[48];
  std::snprintf(name, sizeof name, ".lodestream-build-%016llx",
                static_cast<unsigned long long>(checksum(std::as_bytes(std::span(whole_name)))));
  return temporary_parent / name;
}

void BuildFolder::lock() {
  const auto fail = [&](const char* what) {
    throw Error(ErrorCode::kIo, std::string("cannot ") + what + " " + path_.string() + ": " +
                                    std::strerror(errno) + "; choose another output folder");
  };
  while (true) {
    makeOwnFolder(path_, {"the output", "choose another output folder"});
    lock_ = ::open((path_ / "lock").c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (lock_ < 0 && errno == ENOENT) continue;  // another build ended and removed the folder
    if (lock_ < 0) fail("open the lock in");
    struct stat status {};
    const int locked = ::flock(lock_, LOCK_EX | LOCK_NB);
    if (locked == 0 && ::fstat(lock_, &status) == 0 && status.st_nlink > 0) return;
    const int error = errno;
    ::close(lock_);
    if (locked == 0) continue;
    if (error == EWOULDBLOCK) {
      throw Error(ErrorCode::kIo,
                  output_.string() + ": another process is building it; wait, or name another output");
    }
    errno = error;
    fail("lock");
  }
}

void BuildFolder::clear(const std::filesystem::path& temporary_parent) {
  removeAll(filesIn(temporary_parent));
  removeAll(files_);
  ::unlink(store().c_str());
  ::unlink(journal().c_str());
}

TemporaryFolder BuildFolder::openFiles() { return TemporaryFolder::lasting(files_); }

void BuildFolder::removeFilesBut(std::span<const std::string_view> names) const {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(files_, ignored)) {
    const std::string name = entry.path().filename().string();
    if (std::find(names.begin(), names.end(), name) == names.end()) removeAll(entry.path());
  }
}

void BuildFolder::syncFolders() const {
  syncFolder(output_folder_);
  syncFolder(path_);
  syncFolder(files_.parent_path());
}

void BuildFolder::removeWhenInterrupted() {
  unfinished_files_ = Unfinished(files_);
  unfinished_ = Unfinished(path_);
}

void BuildFolder::syncFiles() const { syncFolder(files_); }

}  // namespace lode::ingest
