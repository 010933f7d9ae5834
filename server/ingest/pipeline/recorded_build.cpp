#include "server/ingest/pipeline/recorded_build.h"

#include <string>

#include "common/error.h"

namespace lode::ingest {

void RecordedBuild::add(uint32_t kind, std::span<const std::byte> bytes) {
  RecordReader record(bytes);
  const auto entry = static_cast<BuildEntry>(kind);
  switch (entry) {
    case BuildEntry::kBegun:
      identity = BuildIdentity::load(record);
      break;
    case BuildEntry::kSorting:
      sorting.assign(bytes.begin(), bytes.end());
      break;
    case BuildEntry::kTasks:
      tasks = record.get<uint32_t>();
      break;
    case BuildEntry::kScanned:
    case BuildEntry::kTextures:
    case BuildEntry::kDereferenced:
    case BuildEntry::kPartitioned:
    case BuildEntry::kSimplified:
    case BuildEntry::kPacked:
      stages[entry].assign(bytes.begin(), bytes.end());
      break;
    default:
      throw Error(ErrorCode::kFormat, "the build's journal has an entry of unknown kind " +
                                          std::to_string(kind) + "; build without --resume");
  }
}

}  // namespace lode::ingest
