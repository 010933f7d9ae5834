#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "common/mesh.h"
#include "server/ingest/pipeline/build_identity.h"
#include "server/ingest/soup/dereference.h"
#include "server/ingest/soup/lattice_choice.h"
#include "server/ingest/soup/uv_grid.h"

namespace lode::ingest {

/// Kinds of entries in a build's journal, in the order of the stages. The entry of a finished stage begins
/// with the BuildFacts and all warnings up to that stage.
enum class BuildEntry : uint32_t {
  kBegun = 1,  ///< the build has begun; contains its BuildIdentity
  kScanned = 2,
  kTextures = 3,      ///< tiles are encoded; written only if the input names images
  kSorting = 4,       ///< progress of dereference with its sorted runs; each entry replaces the previous one
  kDereferenced = 5,  ///< triangles are sorted; written only if they were sorted on disk
  kPartitioned = 6,
  kTasks =
      7,  ///< number of tasks that a build in parts is prepared for; each entry replaces the previous one
  kSimplified = 8,
  kPacked = 9,  ///< the store is complete and has its final name
};

/// Facts about the model that one stage finds and later stages need.
struct BuildFacts {
  LatticeChoice choice;  ///< scan sets this member and the next three
  /// Attributes taken from the file; without normals if all normals have length zero.
  AttributeSet soup_attributes;
  UvGrid uv_grid;
  uint64_t dropped_triangles = 0;
  DereferenceCounts counts;  ///< dereference sets this member

  /// Returns the attributes of payloads: soup_attributes, plus computed normals if these lack normals.
  AttributeSet payloadAttributes() const noexcept {
    AttributeSet attributes = soup_attributes;
    if (!attributes.has(AttributeSet::kNormal))
      attributes.bits |= AttributeSet::kNormal | AttributeSet::kComputedNormal;
    return attributes;
  }
};

/// Contents of the journal of an earlier build of the same output, from which this build can resume.
struct RecordedBuild {
  std::optional<BuildIdentity> identity;
  std::map<BuildEntry, std::vector<std::byte>> stages;  ///< entries of finished stages
  std::vector<std::byte> sorting;                       ///< last kSorting entry, or empty
  uint32_t tasks = 0;                                   ///< last kTasks entry, or 0

  /// Adds an entry. @throws Error kFormat, kLimit.
  void add(uint32_t kind, std::span<const std::byte> bytes);
  /// Returns true if the given stage or a later stage is finished.
  bool isPast(BuildEntry stage) const noexcept { return stages.lower_bound(stage) != stages.end(); }
};

}  // namespace lode::ingest
