#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "server/ingest/disk/journal.h"
#include "server/ingest/nodes/simplify_log.h"
#include "server/ingest/pipeline/build_identity.h"

namespace lode::ingest {

/// Entries of a build's journal, in the order of the stages. Those of finished stages begin with what the
/// build knows (BuildFacts) and its warnings.
enum class BuildEntry : uint32_t {
  kBegun = 1,  ///< BuildIdentity
  kScanned = 2,
  kTextures = 3,      ///< where the input names images
  kSorting = 4,       ///< a point within dereference, and the sorted runs so far; the last one counts
  kDereferenced = 5,  ///< only where the soup was sorted on disk
  kPartitioned = 6,
  kNodes = 7,       ///< nodes finished since the last such entry
  kSimplified = 8,  ///< there are no more of them
  kPacked = 9,      ///< the output has its name
};

/// What a killed build's journal vouches for.
struct RecordedBuild {
  std::optional<BuildIdentity> identity;
  std::map<BuildEntry, std::vector<std::byte>> stages;  ///< finished ones, as they were written
  std::vector<std::byte> sorting;                       ///< as it was written; empty where there is none
  FinishedNodes finished;

  /// Adds an entry. @throws Error kFormat, kLimit.
  void add(uint32_t kind, std::span<const std::byte> bytes);
  /// Whether a stage is finished or one after it, which it was needed for.
  bool isPast(BuildEntry stage) const noexcept { return stages.lower_bound(stage) != stages.end(); }
};

}  // namespace lode::ingest
