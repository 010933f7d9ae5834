#include "client/stream/blob_cache.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include <unistd.h>

#include "common/error.h"
#include "proto/limits.h"
#include "proto/messages.h"

namespace lode::stream {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kTrimShare = 16;  // keep() calls trim() whenever it has stored 1/16 of the limit
// Shortest interval between two updates of a file's time of use.
constexpr std::chrono::hours kUseGranularity{1};
// A temporary file of this age is removed, because its writer is gone.
constexpr std::chrono::hours kAbandoned{1};
constexpr uint64_t kMaxSummaryBytes = sizeof(Digest) + proto::kFrameHeaderBytes + proto::kMaxFrameBodyBytes;
constexpr std::string_view kTemporary = ".new-";

/// Reads a file. Returns nothing if there is no such file, and an empty vector if the file is empty or too
/// large.
std::optional<std::vector<std::byte>> readFile(const fs::path& path, uint64_t max_bytes) {
  std::error_code missing;
  // Do not open a pipe, because this would block.
  if (!fs::is_regular_file(path, missing)) return std::nullopt;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return std::nullopt;
  const auto size = static_cast<uint64_t>(std::max<std::streamoff>(file.tellg(), 0));
  if (size == 0 || size > max_bytes) return std::vector<std::byte>();
  std::vector<std::byte> bytes(size);
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!file) bytes.clear();
  return bytes;
}

/// Writes a file atomically, but does not sync it to disk. A crash may leave an incomplete file, but readers
/// detect that its digest does not match.
bool writeFile(const fs::path& path, std::span<const std::byte> bytes) {
  static std::atomic<uint64_t> serial{0};
  std::error_code failed;
  fs::create_directories(path.parent_path(), failed);
  const fs::path temporary = path.parent_path() / (std::string(kTemporary) + std::to_string(getpid()) + "-" +
                                                   std::to_string(++serial));
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) fs::rename(temporary, path, failed);
  if (file && !failed) return true;
  fs::remove(temporary, failed);
  return false;
}

fs::path summaryFile(const fs::path& folder, const ServedModel& model) {
  const std::string key = toString(model);
  return folder / "models" / toHex(digestOf(std::as_bytes(std::span(key))));
}

/// Creates and removes a file in the folder. Returns the error, if any.
std::error_code triedToWriteTo(const fs::path& folder) {
  std::string name = folder / (std::string(kTemporary) + "XXXXXX");
  const int file = mkstemp(name.data());
  if (file < 0) return {errno, std::generic_category()};
  close(file);
  unlink(name.c_str());
  return {};
}

}  // namespace

void prepareCacheFolder(const fs::path& folder, const core::Remedies& remedies) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (!failed) failed = triedToWriteTo(folder);
  if (failed)
    throw Error(ErrorCode::kIo, folder.string() + ": the cache folder is not writable (" + failed.message() +
                                    "); " + remedies.cache_folder);
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
    fs::remove(path, ignored);
    return std::nullopt;
  }
  const auto now = fs::file_time_type::clock::now();
  if (now - fs::last_write_time(path, ignored) > kUseGranularity) fs::last_write_time(path, now, ignored);
  return bytes;
}

void BlobCache::keep(const BlobRef& blob, std::span<const std::byte> bytes) {
  if (bytes.size() > max_bytes_ / kTrimShare) return;
  kept_bytes_ += bytes.size();
  if (kept_bytes_ > max_bytes_ / kTrimShare) trim();
  writeFile(fileOf(blob.digest), bytes);
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
  writeFile(summaryFile(folder_, model), bytes);
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
  for (fs::recursive_directory_iterator entry(folder_ / "blobs", failed), end; !failed && entry != end;
       entry.increment(failed)) {
    std::error_code gone;  // ignored: set if another process has removed the file
    if (!entry->is_regular_file(gone)) continue;
    const File file{entry->last_write_time(gone), entry->file_size(gone), entry->path()};
    if (gone) continue;
    if (file.path.filename().string().starts_with(kTemporary)) {
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
