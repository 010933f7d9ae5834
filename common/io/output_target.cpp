#include "common/io/output_target.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <deque>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"

namespace lode {
namespace {

constexpr int kMostLinks = 40;  // the kernel has the same limit

[[noreturn]] void refuse(const std::filesystem::path& asked, const char* what) {
  throw Error(ErrorCode::kUsage, asked.string() + ": is " + what + ": name a file to write");
}

/// Refuses a link that another user owns in a sticky folder such as /tmp, as the kernel does when it follows
/// links by itself. @param folder  the link's folder, without links.
void refuseForeignLink(const std::filesystem::path& asked, const std::filesystem::path& folder,
                       const struct stat& link) {
  struct stat status {};
  if (link.st_uid == ::geteuid() || ::stat(folder.empty() ? "." : folder.c_str(), &status) != 0 ||
      (status.st_mode & S_ISVTX) == 0)
    return;
  throw Error(ErrorCode::kIo, asked.string() + ": leads through a link of another user in " +
                                  (folder.empty() ? "this folder" : folder.string()) +
                                  ", where everybody can place links: name another file");
}

/// Returns true if a new file may replace the file to which standard output goes. That file must be empty and
/// not open for appending, because text printed before or after the replacement would be lost.
bool mayReplaceStandardOutput(const std::filesystem::path& file) noexcept {
  const int flags = ::fcntl(STDOUT_FILENO, F_GETFL);
  return isStandardOutput(file) && flags != -1 && (flags & O_APPEND) == 0 &&
         ::lseek(STDOUT_FILENO, 0, SEEK_CUR) == 0;
}

}  // namespace

std::filesystem::path followLinks(const std::filesystem::path& asked) {
  std::filesystem::path path;
  std::deque<std::filesystem::path> rest(asked.begin(), asked.end());
  for (int links = 0; !rest.empty();) {
    std::filesystem::path next = path / rest.front();
    rest.pop_front();
    struct stat status {};
    if (::lstat(next.c_str(), &status) != 0 || !S_ISLNK(status.st_mode)) {
      path = std::move(next);
      continue;
    }
    if (++links > kMostLinks)
      throw Error(ErrorCode::kIo, asked.string() + ": " + std::strerror(ELOOP) + ": name a file to write");
    refuseForeignLink(asked, path, status);
    std::error_code failed;
    const std::filesystem::path target = std::filesystem::read_symlink(next, failed);
    if (failed) throw Error(ErrorCode::kIo, asked.string() + ": " + failed.message());
    if (target.is_absolute()) path.clear();
    rest.insert(rest.begin(), target.begin(), target.end());
  }
  return path;
}

OutputTarget findOutput(const std::filesystem::path& asked) {
  if (asked.empty()) throw Error(ErrorCode::kUsage, "the output's name is empty: name a file to write");
  const std::filesystem::path file = followLinks(asked);
  struct stat status {};
  // Look for pipes and devices under the asked name, because their links in /proc/self/fd do not lead to a
  // path.
  const bool is_there = ::stat(asked.c_str(), &status) == 0;
  if (is_there && (S_ISFIFO(status.st_mode) || S_ISCHR(status.st_mode))) return {asked, true};
  if (is_there && S_ISDIR(status.st_mode)) refuse(asked, "a folder");
  if (is_there && !S_ISREG(status.st_mode)) refuse(asked, "a socket or a block device");
  if (!asked.has_filename()) refuse(asked, "the name of a folder");
  if (file != asked && isStandardOutput(asked) && !mayReplaceStandardOutput(file))
    refuse(asked, "a standard output that is not empty, is open for appending, or has no name");
  return {file};
}

std::filesystem::path findSideFile(const std::filesystem::path& path) {
  const std::filesystem::path file = followLinks(path.parent_path()) / path.filename();
  struct stat status {};
  if (::lstat(file.c_str(), &status) != 0 || (S_ISREG(status.st_mode) && status.st_uid == ::geteuid()))
    return file;
  throw Error(
      ErrorCode::kIo,
      path.string() + ": is " + (S_ISREG(status.st_mode) ? "a file of another user" : "not a regular file") +
          " beside the output, which the command does not overwrite: move it, or name another output");
}

bool isStandardOutput(const std::filesystem::path& output) noexcept {
  struct stat asked {};
  struct stat printed {};
  return ::stat(output.c_str(), &asked) == 0 && ::fstat(STDOUT_FILENO, &printed) == 0 &&
         asked.st_dev == printed.st_dev && asked.st_ino == printed.st_ino;
}

std::FILE* reportStream(const std::filesystem::path& output, bool as_json) {
  if (!isStandardOutput(output)) return stdout;
  if (as_json)
    throw Error(ErrorCode::kUsage,
                output.string() + ": --json prints there too; name a file, or leave out --json");
  return stderr;
}

void refuseFilesBesideStream(const std::filesystem::path& output) {
  // True, for example, if the output is /dev/stdout and the shell redirects stdout to a.ply.
  const bool is_device_of_a_file = isStandardOutput(output) && !output.has_extension();
  if (is_device_of_a_file || findOutput(output).is_stream)
    throw Error(
        ErrorCode::kUsage,
        output.string() + ": is a pipe or a device, so images cannot be written beside it; name a file");
}

std::string fileEnding(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

}  // namespace lode
