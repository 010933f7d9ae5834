#include "server/ingest/nodes/treelet_folder.h"

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include "common/error.h"
#include "common/io/file_io.h"
#include "common/io/own_folder.h"

namespace lode::ingest {
namespace {

constexpr FolderUse kOwn{"finished parts of the build", "name another output"};
constexpr FolderUse kShared{"finished parts of builds", "name another folder with --reuse"};
constexpr size_t kDigits = 2 * sizeof(Digest);
constexpr const char* kSharedSubfolder = "treelets";

bool isTreelet(std::string_view file_name) {
  return file_name.size() == kDigits + kTreeletEnding.size() && file_name.ends_with(kTreeletEnding) &&
         file_name.find_first_not_of("0123456789abcdef") == kDigits;
}

/// Gives a file a second name, or copies it if the names lie on different file systems. Another process may
/// do the same at the same time. @return false on failure.
bool linkOrCopy(const std::filesystem::path& from, const std::filesystem::path& to) noexcept {
  std::error_code error;
  std::filesystem::create_hard_link(from, to, error);
  if (!error || error == std::errc::file_exists) return true;
  std::filesystem::path copy = to;
  copy += temporaryEnding();
  std::filesystem::copy_file(from, copy, std::filesystem::copy_options::overwrite_existing, error);
  if (!error) std::filesystem::rename(copy, to, error);
  std::error_code ignored;
  if (error) std::filesystem::remove(copy, ignored);
  return !error;
}

}  // namespace

TreeletFolder::TreeletFolder(std::filesystem::path own, const std::filesystem::path& shared)
    : own_(std::move(own)), shared_(shared.empty() ? shared : shared / kSharedSubfolder) {
  makeOwnFolder(own_, kOwn);
  if (!shared_.empty()) makeOwnFolders(shared_, kShared);
}

std::optional<TreeletFile> TreeletFolder::find(const Digest& name) const {
  std::error_code ignored;
  const std::filesystem::path path = ownPath(name);
  if (!shared_.empty() && !std::filesystem::exists(path, ignored)) {
    const std::filesystem::path shared = sharedPath(name);
    if (std::filesystem::exists(shared, ignored) && linkOrCopy(shared, path))
      std::filesystem::last_write_time(shared, std::filesystem::file_time_type::clock::now(), ignored);
  }
  std::optional<TreeletFile> file = TreeletFile::open(path);
  if (!file && std::filesystem::remove(path, ignored) && !shared_.empty())
    std::filesystem::remove(sharedPath(name), ignored);
  return file;
}

bool TreeletFolder::has(const Digest& name) const {
  std::error_code ignored;
  return std::filesystem::exists(ownPath(name), ignored);
}

void TreeletFolder::sync() const {
  const int folder = ::open(own_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool is_synced = folder >= 0 && ::syncfs(folder) == 0;
  const int error = errno;
  if (folder >= 0) ::close(folder);
  if (!is_synced)
    throw Error(ErrorCode::kIo, "cannot sync folder " + own_.string() + ": " + fileErrorInWords(error));
}

void TreeletFolder::share(const Digest& name) const noexcept {
  if (!shared_.empty()) linkOrCopy(ownPath(name), sharedPath(name));
}

void trimSharedTreelets(const std::filesystem::path& shared, uint64_t limit_bytes) {
  struct File {
    std::filesystem::file_time_type used;
    std::filesystem::path path;
    uint64_t bytes = 0;
  };
  std::vector<File> files;
  uint64_t bytes = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(shared / kSharedSubfolder, error)) {
    if (!isTreelet(entry.path().filename().string())) continue;
    std::error_code gone;
    const File file{entry.last_write_time(gone), entry.path(), entry.file_size(gone)};
    if (gone) continue;
    bytes += file.bytes;
    files.push_back(file);
  }
  std::sort(files.begin(), files.end(), [](const File& a, const File& b) {
    return std::pair(a.used, a.path) < std::pair(b.used, b.path);
  });
  for (const File& file : files) {
    if (bytes <= limit_bytes) return;
    if (std::filesystem::remove(file.path, error)) bytes -= file.bytes;
  }
}

}  // namespace lode::ingest
