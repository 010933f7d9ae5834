#include "common/io/output_target.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <system_error>

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

/// Follows symbolic links, even if the last link points to a missing file.
std::filesystem::path behindLinks(const std::filesystem::path& asked) {
  std::filesystem::path path = asked;
  for (int links = 0; links < kMostLinks; ++links) {
    std::error_code no_link;
    const std::filesystem::path next = std::filesystem::read_symlink(path, no_link);
    if (no_link) return path;
    path = path.parent_path() / next;  // an absolute `next` replaces the parent path
  }
  throw Error(ErrorCode::kIo, asked.string() + ": " + std::strerror(ELOOP) + ": name a file to write");
}

/// Returns true if a new file may replace the file to which standard output goes. That file must be empty,
/// and not opened for appending, because all text printed before or after the replacement is lost.
bool mayReplaceStandardOutput(const std::filesystem::path& file) noexcept {
  const int flags = ::fcntl(STDOUT_FILENO, F_GETFL);
  return isStandardOutput(file) && flags != -1 && (flags & O_APPEND) == 0 &&
         ::lseek(STDOUT_FILENO, 0, SEEK_CUR) == 0;
}

}  // namespace

OutputTarget findOutput(const std::filesystem::path& asked) {
  if (asked.empty()) throw Error(ErrorCode::kUsage, "the output's name is empty: name a file to write");
  struct stat status {};
  // Check for pipes and devices before following links, because a link in /proc/self/fd need not lead to a
  // name.
  const bool is_there = ::stat(asked.c_str(), &status) == 0;
  if (is_there && (S_ISFIFO(status.st_mode) || S_ISCHR(status.st_mode))) return {asked, true};
  if (is_there && S_ISDIR(status.st_mode)) refuse(asked, "a folder");
  if (is_there && !S_ISREG(status.st_mode)) refuse(asked, "a socket or a block device");
  if (!asked.has_filename()) refuse(asked, "the name of a folder");
  const std::filesystem::path file = behindLinks(asked);
  if (file != asked && isStandardOutput(asked) && !mayReplaceStandardOutput(file))
    refuse(asked, "a standard output that is not empty, is open for appending, or has no name");
  return {file};
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
  // For example --output /dev/stdout > a.ply.
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
