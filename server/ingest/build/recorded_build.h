#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "server/ingest/build/build_identity.h"
#include "server/ingest/disk/journal.h"
#include "server/ingest/nodes/simplify_log.h"

namespace lode::ingest {

/// Entries of a build's journal, in the order of the stages.
enum class BuildEntry : uint32_t {
  kBegun = 1,         ///< BuildIdentity
  kScanned = 2,       ///< what is known of the model, and the packed input
  kSorting = 3,       ///< a point within dereference, and the sorted runs so far; the last one counts
  kDereferenced = 4,  ///< counts, and all sorted runs; only where the soup was sorted on disk
  kPartitioned = 5,   ///< counts, and the partition
  kNodes = 6,         ///< nodes finished since the last such entry
  kSimplified = 7,    ///< there are no more of them
  kPacked = 8,        ///< PackedStore: the output has its name
  kTextures = 9,      ///< warnings, and the tiles; after kScanned, where the input names images
};

struct PackedStore {
  BlobName build_id;
  uint64_t bytes = 0;
};

/// What a killed build's journal vouches for: entries as they were written, empty where there is none.
struct RecordedBuild {
  std::optional<BuildIdentity> identity;
  std::vector<std::byte> scanned, textures, sorting, dereferenced, partitioned;
  FinishedNodes finished;
  bool is_simplified = false;
  std::optional<PackedStore> packed;

  /// Adds an entry. @throws Error kFormat, kLimit.
  void add(uint32_t kind, std::span<const std::byte> bytes);
};

}  // namespace lode::ingest
