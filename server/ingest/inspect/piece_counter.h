#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/groups.h"
#include "server/ingest/disk/spool.h"
#include "server/ingest/disk/temporary_folder.h"

namespace lode::ingest {

/// Counts how many joins of two vertices merge two pieces (connected sets of vertices), for any number of
/// vertices in bounded memory. Processes ranges of vertex indices one after another, from the largest indices
/// to the smallest. If a group of joined vertices in the current range is joined to a vertex in a later
/// range, this vertex becomes the group's anchor. Each further join of the group to a later range is replaced
/// by a join of the anchor, which waits for the range that contains its larger index. Not thread safe. All
/// functions throw Error kIo.
class PieceCounter {
 public:
  /// @param folder  folder for the joins that wait for later ranges. @param memory_bytes  limit; the counter
  /// never needs more than eight bytes per vertex.
  PieceCounter(uint64_t vertices, uint64_t memory_bytes, const TemporaryFolder& folder);

  void join(uint32_t a, uint32_t b);
  /// Returns the number of joins that merged two pieces: number of vertices minus number of pieces. Call it
  /// last.
  uint64_t countJoins();

 private:
  struct Join {
    uint32_t high, low;
  };
  void open(size_t range);
  void joinInRange(Join join);
  void handDown(uint32_t a, uint32_t b);

  const uint64_t range_vertices_;
  size_t range_ = 0;  ///< index of the current range; ranges with larger indices are done
  /// For each range still to come, the joins whose larger index lies in it.
  std::vector<std::unique_ptr<Spool>> lower_;
  Groups groups_{0};               ///< groups in the current range
  std::vector<uint32_t> anchors_;  ///< anchor of each group of the current range, or kNone
  uint64_t joins_ = 0;
};

}  // namespace lode::ingest
