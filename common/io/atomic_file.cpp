#include "common/io/atomic_file.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <span>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "common/error.h"
#include "common/io/file_io.h"
#include "common/io/output_target.h"

namespace lode {
namespace {

constexpr size_t kBufferBytes = 256u << 10;

[[noreturn]] void fail(const char* what, const std::filesystem::path& path, int error) {
  throw Error(ErrorCode::kIo, "cannot " + std::string(what) + " " + path.string() + ": " +
                                  fileErrorInWords(error, "free some space or choose another place"));
}

[[noreturn]] void failToCreate(const std::filesystem::path& path, int error) {
  if (error == ENOSPC || error == EDQUOT) fail("create", path, error);
  throw Error(ErrorCode::kIo, "cannot create " + path.string() + ": " + fileErrorInWords(error) +
                                  "; name a folder that is there and can be written");
}

std::filesystem::path directoryOf(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

// Returns the path of a temporary file beside the target. No other writer of this or another process uses the
// path.
std::filesystem::path temporaryName(const std::filesystem::path& path) {
  static std::atomic<unsigned> counter{0};
  std::filesystem::path name = path;
  name += "." + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp";
  return name;
}

void syncDirectory(const std::filesystem::path& directory) {
  const int file = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) fail("open folder", directory, errno);
  const int error = ::fsync(file) == 0 ? 0 : errno;
  ::close(file);
  // Ignore EINVAL: some network file systems cannot sync a folder, and the rename has succeeded.
  if (error != 0 && error != EINVAL) fail("sync folder", directory, error);
}

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path path, std::filesystem::path temporary, OutputName name)
    : path_(std::move(path)), temporary_(std::move(temporary)) {
  OutputTarget target =
      name == OutputName::kTyped ? findOutput(path_) : OutputTarget{.path = findSideFile(path_)};
  if (target.is_stream) {
    temporary_.clear();
    file_ = ::open(path_.c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC);
    if (file_ < 0) fail("open", path_, errno);
    return;
  }
  target_ = std::move(target.path);
  if (!temporary_.empty()) {
    file_ = ::open(temporary_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (file_ < 0) failToCreate(path_, errno);
    return;
  }
  const Uninterrupted until_it_is_known;
  do {  // a killed process with the same process id may have left a file of this name
    temporary_ = temporaryName(target_);
    file_ = ::open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (file_ < 0 && errno == EEXIST);
  if (file_ < 0) failToCreate(path_, errno);
  unfinished_ = Unfinished(temporary_);
}

AtomicFile::~AtomicFile() {
  if (file_ >= 0) ::close(file_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, {})),
      unfinished_(std::move(other.unfinished_)),
      file_(std::exchange(other.file_, -1)),
      size_(std::exchange(other.size_, 0)),
      buffer_(std::exchange(other.buffer_, {})) {}

void AtomicFile::write(std::span<const std::byte> bytes) {
  if (bytes.size() + buffer_.size() > kBufferBytes) flush();
  buffer_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  size_ += bytes.size();
  if (buffer_.size() > kBufferBytes) flush();
}

void AtomicFile::writeAt(uint64_t offset, std::span<const std::byte> bytes) {
  if (offset > size_ || bytes.size() > size_ - offset)
    throw Error(ErrorCode::kInternal, "write beyond the end of " + path_.string());
  if (target_.empty())
    throw Error(ErrorCode::kUsage, path_.string() +
                                       ": is a pipe or a device, but this output must be a file; "
                                       "name a file");
  flush();
  if (!lode::writeAt(file_, offset, bytes)) fail("write", path_, errno);
}

uint64_t AtomicFile::size() const noexcept { return size_; }

void AtomicFile::flush() {
  const auto bytes = std::as_bytes(std::span(buffer_));
  const bool is_written =
      target_.empty() ? append(file_, bytes) : lode::writeAt(file_, size_ - bytes.size(), bytes);
  if (!is_written) fail("write", path_, errno);
  buffer_.clear();
}

void AtomicFile::commit() {
  flush();
  if (!target_.empty() && ::fsync(file_) != 0) fail("sync", path_, errno);
  if (::close(std::exchange(file_, -1)) != 0) fail("close", path_, errno);
  if (target_.empty()) return;
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail("rename a finished file to", path_, errno);
  temporary_.clear();
  unfinished_.finish();
  syncDirectory(directoryOf(target_));
}

}  // namespace lode
