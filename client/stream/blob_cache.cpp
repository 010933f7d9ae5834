#include "client/stream/blob_cache.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"
#include "common/io/file_io.h"
#include "common/io/output_target.h"
#include "common/io/own_folder.h"
#include "proto/limits.h"
#include "proto/messages.h"

namespace lode::stream {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kTrimShare = 16;  // keep() calls trim() after storing 1/16 of the limit
// Shortest interval between two updates of a file's time of last use.
constexpr std::chrono::hours kUseGranularity{1};
// Age at which a temporary file is removed, because its writer must have ended.
constexpr std::chrono::hours kAbandoned{1};
constexpr uint64_t kMaxSummaryBytes = sizeof(Digest) + proto::kFrameHeaderBytes + proto::kMaxFrameBodyBytes;
constexpr FolderUse kCacheUse{
    .what = "the cache", .if_not_made = Remedy::kCacheFolder, .if_foreign = Remedy::kForeignCacheFolder};

/// Reads a file. Returns nothing if there is no regular file at the path, and an empty vector if the file is
/// empty, too large or unreadable.
std::optional<std::vector<std::byte>> readFile(const fs::path& path, uint64_t max_bytes) {
  // O_NONBLOCK, because opening a pipe would block.
  const int file = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  struct stat status {};
  std::optional<std::vector<std::byte>> bytes;
  if (::fstat(file, &status) == 0 && S_ISREG(status.st_mode)) {
    const auto size = static_cast<uint64_t>(status.st_size);
    bytes.emplace(size > max_bytes ? 0 : size);
    if (readAt(file, 0, *bytes) != bytes->size()) bytes->clear();
  }
  ::close(file);
  return bytes;
}

/// Creates the folder of a file and all folders between it and the cache folder. @return false if one of them
/// cannot be created or fails isOwnFolder().
bool makeFoldersOf(const fs::path& file, const fs::path& cache) {
  try {
    std::error_code missing;
    if (!fs::is_directory(cache, missing)) makeOwnFolders(cache, kCacheUse);
    fs::path folder = cache;
    for (const fs::path& name : file.parent_path().lexically_relative(cache))
      makeOwnFolder(folder /= name, kCacheUse);
    return true;
  } catch (const Error&) {
    return false;
  }
}

fs::path summaryFile(const fs::path& folder, const ServedModel& model) {
  const std::string key = toString(model);
  return folder / "models" / toHex(digestOf(std::as_bytes(std::span(key))));
}

/// Creates and removes a file in the folder. Returns the error, if any.
std::error_code triedToWriteTo(const fs::path& folder) {
  std::string name = folder / (std::string(kNewFile) + "XXXXXX");
  const int file = mkstemp(name.data());
  if (file < 0) return {errno, std::generic_category()};
  close(file);
  unlink(name.c_str());
  return {};
}

}  // namespace

void prepareCacheFolder(const fs::path& folder) {
  followLinks(folder);  // throws for a link of another user
  std::error_code failed;
  if (!fs::is_directory(folder, failed)) makeOwnFolders(folder, kCacheUse);
  failed = triedToWriteTo(folder);
  if (failed)
    throw Error(ErrorCode::kIo,
                folder.string() + ": the cache folder is not writable (" + failed.message() + ")",
                Remedy::kCacheFolder);
}

BlobCache::BlobCache(fs::path folder, uint64_t max_bytes)
    : folder_(std::move(folder)), max_bytes_(max_bytes), kept_bytes_(max_bytes) {}

fs::path BlobCache::fileOf(const Digest& name) const {
  const std::string hex = toHex(name);
  return folder_ / "blobs" / hex.substr(0, 2) / hex;
}

std::optional<std::vector<std::byte>> BlobCache::find(const BlobRef& blob) {
  const fs::path path = fileOf(blob.digest);
  auto bytes = readFile(path, blob.bytes);
  if (!bytes) return std::nullopt;
  std::error_code ignored;
  if (bytes->size() != blob.bytes || digestOf(*bytes) != blob.digest) {
    if (makeFoldersOf(path, folder_)) fs::remove(path, ignored);
    return std::nullopt;
  }
  const auto now = fs::file_time_type::clock::now();
  if (now - fs::last_write_time(path, ignored) > kUseGranularity) fs::last_write_time(path, now, ignored);
  return bytes;
}

void BlobCache::store(const fs::path& file, std::span<const std::byte> bytes) const {
  if (makeFoldersOf(file, folder_)) writeOwnFile(file, bytes);  // no sync: reads detect damage by a crash
}

void BlobCache::keep(const BlobRef& blob, std::span<const std::byte> bytes) {
  if (bytes.size() > max_bytes_ / kTrimShare) return;
  kept_bytes_ += bytes.size();
  if (kept_bytes_ > max_bytes_ / kTrimShare) trim();
  store(fileOf(blob.digest), bytes);
}

/// Reads a summary file. The file contains an Opened frame, preceded by the frame's digest.
std::optional<ModelSummary> BlobCache::summary(const ServedModel& model) const {
  const auto bytes = readFile(summaryFile(folder_, model), kMaxSummaryBytes);
  if (!bytes || bytes->size() < sizeof(Digest) + proto::kFrameHeaderBytes) return std::nullopt;
  const std::span<const std::byte> frame = std::span(*bytes).subspan(sizeof(Digest));
  if (!std::ranges::equal(digestOf(frame).bytes, std::span(*bytes).first(sizeof(Digest))))
    return std::nullopt;
  try {
    auto opened = proto::decode<proto::Opened>(frame.subspan(proto::kFrameHeaderBytes));
    if (opened.summary.name != model.model) return std::nullopt;
    return std::move(opened.summary);
  } catch (const std::exception&) {
    return std::nullopt;  // another version wrote the file
  }
}

void BlobCache::keepSummary(const ServedModel& model, const ModelSummary& summary) {
  const proto::Bytes frame = proto::encode(proto::Opened{1, summary}, 0);
  const Digest name = digestOf(frame);
  std::vector<std::byte> bytes(name.bytes.begin(), name.bytes.end());
  bytes.insert(bytes.end(), frame.begin(), frame.end());
  store(summaryFile(folder_, model), bytes);
}

void BlobCache::trim() {
  struct File {
    fs::file_time_type used;
    uint64_t bytes = 0;
    fs::path path;
  };
  kept_bytes_ = 0;
  const auto now = fs::file_time_type::clock::now();
  std::vector<File> files;
  uint64_t bytes = 0;
  std::error_code failed;
  if (!isOwnFolder(folder_ / "blobs")) return;  // the iterator would follow a link
  for (fs::recursive_directory_iterator entry(folder_ / "blobs", failed), end; !failed && entry != end;
       entry.increment(failed)) {
    std::error_code gone;  // ignored: set if another process has removed the file
    if (!entry->is_regular_file(gone)) continue;
    const File file{entry->last_write_time(gone), entry->file_size(gone), entry->path()};
    if (gone) continue;
    if (file.path.filename().string().starts_with(kNewFile)) {
      if (now - file.used > kAbandoned) fs::remove(file.path, gone);
      continue;
    }
    bytes += file.bytes;
    files.push_back(file);
  }
  const uint64_t target = max_bytes_ - max_bytes_ / kTrimShare;
  if (bytes <= target) return;
  std::sort(files.begin(), files.end(), [](const File& a, const File& b) { return a.used < b.used; });
  for (const File& file : files) {
    if (bytes <= target) return;
    if (fs::remove(file.path, failed)) bytes -= file.bytes;
  }
}

}  // namespace lode::stream
