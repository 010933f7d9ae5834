#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "server/ingest/disk/spool.h"
#include "server/ingest/disk/temporary_folder.h"
#include "server/ingest/mesh/groups.h"

namespace lode::ingest {

/// Counts how many of the joins between vertices make two pieces one, of any number of vertices in a bounded
/// memory: vertices are taken by ranges of their numbers, from the highest down. A piece within a range that
/// joins lower vertices becomes one of these, and what else joined it is handed down as a join of that one.
/// For one thread. All functions throw Error kIo.
class PieceCounter {
 public:
  /// @param folder  for what is handed down. @param memory_bytes  eight a vertex are used at most.
  PieceCounter(uint64_t vertices, uint64_t memory_bytes, const TemporaryFolder& folder);

  void join(uint32_t a, uint32_t b);
  /// The last call. @return pieces that there are fewer than vertices.
  uint64_t countJoins();

 private:
  struct Join {
    uint32_t high, low;
  };
  void open(size_t range);
  void joinInRange(Join join);
  void handDown(uint32_t a, uint32_t b);

  const uint64_t range_vertices_;
  size_t range_ = 0;                           ///< that is open; joins of higher ones have been dealt with
  std::vector<std::unique_ptr<Spool>> lower_;  ///< joins of each range below, by their higher end
  Groups groups_{0};                           ///< of the open range
  std::vector<uint32_t> anchors_;              ///< of a group: a lower vertex that it hangs on, or kNone
  uint64_t joins_ = 0;
};

}  // namespace lode::ingest
