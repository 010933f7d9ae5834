#include "server/ingest/build/recorded_build.h"

namespace lode::ingest {

void RecordedBuild::add(uint32_t kind, std::span<const std::byte> bytes) {
  RecordReader record(bytes);
  switch (static_cast<BuildEntry>(kind)) {
    case BuildEntry::kBegun:
      identity = BuildIdentity::load(record);
      break;
    case BuildEntry::kScanned:
      scanned.assign(bytes.begin(), bytes.end());
      break;
    case BuildEntry::kTextures:
      textures.assign(bytes.begin(), bytes.end());
      break;
    case BuildEntry::kSorting:
      sorting.assign(bytes.begin(), bytes.end());
      break;
    case BuildEntry::kDereferenced:
      dereferenced.assign(bytes.begin(), bytes.end());
      break;
    case BuildEntry::kPartitioned:
      partitioned.assign(bytes.begin(), bytes.end());
      break;
    case BuildEntry::kNodes:
      finished.add(record);
      break;
    case BuildEntry::kSimplified:
      is_simplified = true;
      break;
    case BuildEntry::kPacked:
      packed = record.get<PackedStore>();
      break;
    default:
      throw Error(ErrorCode::kFormat, "the journal of a build has an entry of unknown kind " +
                                          std::to_string(kind) + "; build without --resume");
  }
}

}  // namespace lode::ingest
