#include "common/io/atomic_folder.h"

#include <atomic>
#include <cerrno>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"
#include "common/io/file_io.h"
#include "common/io/output_target.h"

namespace lode {
namespace {

[[noreturn]] void failTo(const char* what, const std::filesystem::path& path, int error) {
  throw Error(ErrorCode::kIo, std::string("cannot ") + what + " " + path.string() + ": " +
                                  fileErrorInWords(error, "free some space, or name another folder"));
}

[[noreturn]] void refuseFull(const std::filesystem::path& path) {
  throw Error(ErrorCode::kUsage,
              path.string() + " exists and is not an empty folder; name a new folder, or remove this one");
}

/// Returns the path without links and without a slash at its end.
std::filesystem::path targetOf(const std::filesystem::path& path) {
  std::filesystem::path target = followLinks(path).lexically_normal();
  if (!target.has_filename()) target = target.parent_path();
  if (!target.has_filename() || target.filename() == "." || target.filename() == "..") refuseFull(path);
  return target;
}

std::filesystem::path folderAbove(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

/// Refuses a folder that cannot be replaced, because a file system is mounted on it.
void refuseMountPoint(const std::filesystem::path& path) {
  struct stat inside {};
  struct stat above {};
  if (::stat(path.c_str(), &inside) == 0 && ::stat(folderAbove(path).c_str(), &above) == 0 &&
      inside.st_dev != above.st_dev)
    throw Error(ErrorCode::kUsage, path.string() + " is a mount point; name a new folder in it");
}

/// Syncs a folder, or with `whole` all files of its file system.
void sync(const std::filesystem::path& folder, bool whole) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) failTo("open folder", folder, errno);
  const int error = (whole ? ::syncfs(file) : ::fsync(file)) == 0 ? 0 : errno;
  ::close(file);
  if (error != 0 && error != EINVAL) failTo("sync folder", folder, error);  // EINVAL: cannot be synced
}

}  // namespace

AtomicFolder::AtomicFolder(const std::filesystem::path& path) : target_(targetOf(path)) {
  refuseMountPoint(target_);
  std::error_code failed;
  if (std::filesystem::exists(std::filesystem::symlink_status(target_, failed)) &&
      !(std::filesystem::is_directory(target_, failed) && std::filesystem::is_empty(target_, failed)))
    refuseFull(path);
  static std::atomic<unsigned> counter{0};
  int error = 0;
  const Uninterrupted until_it_is_known;
  do {  // a killed process with the same process id may have left a folder of this name
    temporary_ =
        folderAbove(target_) / ("." + target_.filename().string() + "." + std::to_string(::getpid()) + "-" +
                                std::to_string(counter++) + ".tmp");
    error = ::mkdir(temporary_.c_str(), 0777) == 0 ? 0 : errno;
  } while (error == EEXIST);
  if (error != 0) {
    temporary_.clear();
    failTo("create folder", path, error);
  }
  unfinished_ = Unfinished(temporary_);
}

AtomicFolder::~AtomicFolder() {
  std::error_code ignored;
  if (!temporary_.empty()) std::filesystem::remove_all(temporary_, ignored);
}

void AtomicFolder::makeFolder(const std::filesystem::path& name) {
  if (::mkdir((temporary_ / name).c_str(), 0777) != 0) failTo("create folder", target_ / name, errno);
}

void AtomicFolder::write(const std::filesystem::path& name, std::span<const std::byte> bytes) const {
  const int file = ::open((temporary_ / name).c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file < 0) failTo("create", target_ / name, errno);
  const int error = append(file, bytes) ? 0 : errno;
  if (::close(file) != 0 || error != 0) failTo("write", target_ / name, error != 0 ? error : errno);
}

void AtomicFolder::commit() {
  sync(temporary_, true);
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) {
    if (errno == ENOTEMPTY || errno == EEXIST || errno == ENOTDIR) refuseFull(target_);
    failTo("rename a finished folder to", target_, errno);
  }
  temporary_.clear();
  unfinished_.finish();
  sync(folderAbove(target_), false);
}

}  // namespace lode
