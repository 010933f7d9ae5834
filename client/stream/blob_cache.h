#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "client/core/session/remedies.h"
#include "client/stream/served_model.h"
#include "common/codec/blob.h"
#include "common/codec/model_summary.h"

namespace lode::stream {

constexpr uint64_t kDefaultCacheBytes = 4ull << 30;

/// Makes a folder that was asked for and tries it at once: blobs that cannot be kept are let go without a
/// word. @throws Error kIo if nothing can be kept there.
void prepareCacheFolder(const std::filesystem::path& folder, const core::Remedies& remedies);

/// Blobs on disk, by name, one file each, and which build of a model a server had last. Any number of
/// processes may share a folder: a file appears whole under its name, and what is read is checked against it,
/// so that what a crash or a bad disk has damaged is removed and fetched again. Least recently used files go
/// first when there are too many bytes. Errors of the disk make it forget, never fail. Not thread safe.
class BlobCache {
 public:
  /// @param folder  is made when the first blob is kept.
  BlobCache(std::filesystem::path folder, uint64_t max_bytes);

  /// The bytes of a blob, if they are there and have its name.
  std::optional<std::vector<std::byte>> find(const BlobRef& blob);
  void keep(const BlobRef& blob, std::span<const std::byte> bytes);

  /// The summary that keepSummary() was given last for a model of a server.
  std::optional<ModelSummary> summary(const ServedModel& model) const;
  void keepSummary(const ServedModel& model, const ModelSummary& summary);

  /// Removes the least recently used beyond the limit. keep() does so by itself after every so many bytes.
  void trim();

 private:
  std::filesystem::path fileOf(const Digest& name) const;

  std::filesystem::path folder_;
  uint64_t max_bytes_;
  uint64_t kept_bytes_ = 0;  // since the last trim()
};

}  // namespace lode::stream
