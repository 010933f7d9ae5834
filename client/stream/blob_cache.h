#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "client/stream/served_model.h"
#include "common/codec/blob.h"
#include "common/codec/model_summary.h"

namespace lode::stream {

constexpr uint64_t kDefaultCacheBytes = 4ull << 30;

/// Creates a cache folder if it is missing (mode 0700) and checks that it is writable, because BlobCache
/// ignores write errors. @throws Error kIo, with Remedy::kCacheFolder or kForeignCacheFolder, if the folder
/// is not writable, or as followLinks().
void prepareCacheFolder(const std::filesystem::path& folder);

/// Caches blobs on disk, one file per blob, named by digest. Also caches the last summary of each served
/// model. Only this user can access the files and the folders below the cache folder. The cache writes and
/// removes nothing through a link or in a folder of another user. Any number of processes may share a folder,
/// because files appear atomically. Each read verifies the digest; a file that a crash or a bad disk has
/// damaged is removed and counts as a miss. Evicts the least recently used files. Disk errors cause misses,
/// never exceptions. Not thread safe.
class BlobCache {
 public:
  /// @param folder  folder of the cache, created when the first blob is stored.
  BlobCache(std::filesystem::path folder, uint64_t max_bytes);

  /// Returns the bytes of a blob if the cache has them and they match the digest.
  std::optional<std::vector<std::byte>> find(const BlobRef& blob);
  void keep(const BlobRef& blob, std::span<const std::byte> bytes);

  /// Returns the last summary passed to keepSummary() for a served model.
  std::optional<ModelSummary> summary(const ServedModel& model) const;
  void keepSummary(const ServedModel& model, const ModelSummary& summary);

  /// Evicts the least recently used files until the rest fits 15/16 of the limit. keep() calls trim() each
  /// time another 1/16 of the limit has been stored.
  void trim();

 private:
  std::filesystem::path fileOf(const Digest& name) const;
  void store(const std::filesystem::path& file, std::span<const std::byte> bytes) const;

  std::filesystem::path folder_;
  uint64_t max_bytes_;
  uint64_t kept_bytes_ = 0;  // bytes stored since the last trim()
};

}  // namespace lode::stream
