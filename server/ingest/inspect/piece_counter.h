#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "server/ingest/disk/spool.h"
#include "server/ingest/disk/temporary_folder.h"
#include "server/ingest/mesh/groups.h"

namespace lode::ingest {

/// Counts how many joins between vertices merge two pieces, for any number of vertices in bounded memory.
/// Processes ranges of vertex numbers from the highest down. A group of the open range that joins a lower
/// vertex is anchored to it; its further joins are passed to the lower range as joins of that vertex. Not
/// thread safe. All functions throw Error kIo.
class PieceCounter {
 public:
  /// @param folder  for joins of lower ranges. @param memory_bytes  at most eight bytes per vertex are used.
  PieceCounter(uint64_t vertices, uint64_t memory_bytes, const TemporaryFolder& folder);

  void join(uint32_t a, uint32_t b);
  /// Must be the last call. @return number of vertices minus number of pieces.
  uint64_t countJoins();

 private:
  struct Join {
    uint32_t high, low;
  };
  void open(size_t range);
  void joinInRange(Join join);
  void handDown(uint32_t a, uint32_t b);

  const uint64_t range_vertices_;
  size_t range_ = 0;                           ///< the open range; higher ones are done
  std::vector<std::unique_ptr<Spool>> lower_;  ///< joins of each lower range, by their higher end
  Groups groups_{0};                           ///< groups in the open range
  std::vector<uint32_t> anchors_;              ///< lower vertex that a group is joined to, or kNone
  uint64_t joins_ = 0;
};

}  // namespace lode::ingest
