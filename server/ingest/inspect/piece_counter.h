#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "server/ingest/disk/spool.h"
#include "server/ingest/disk/temporary_folder.h"
#include "server/ingest/mesh/groups.h"

namespace lode::ingest {

/// Counts how many joins between vertices merge two pieces, for any number of vertices in bounded memory.
/// Processes ranges of vertex numbers one after another, the highest first. When a group of vertices in the
/// current range is joined to a vertex of a lower range, that vertex becomes the group's anchor. Further
/// joins of the group to lower vertices become joins of the anchor, which a lower range processes. Not thread
/// safe. All functions throw Error kIo.
class PieceCounter {
 public:
  /// @param folder  folder for joins of lower ranges. @param memory_bytes  limit; the counter uses at most
  /// eight bytes per vertex.
  PieceCounter(uint64_t vertices, uint64_t memory_bytes, const TemporaryFolder& folder);

  void join(uint32_t a, uint32_t b);
  /// Counts the joins; call it last. @return number of vertices minus number of pieces.
  uint64_t countJoins();

 private:
  struct Join {
    uint32_t high, low;
  };
  void open(size_t range);
  void joinInRange(Join join);
  void handDown(uint32_t a, uint32_t b);

  const uint64_t range_vertices_;
  size_t range_ = 0;  ///< the current range; higher ranges are done
  /// Joins of each lower range: the joins whose higher end lies in the range.
  std::vector<std::unique_ptr<Spool>> lower_;
  Groups groups_{0};               ///< groups in the current range
  std::vector<uint32_t> anchors_;  ///< anchor of each group of the current range, or kNone
  uint64_t joins_ = 0;
};

}  // namespace lode::ingest
