#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <span>
#include <thread>
#include <vector>

#include "common/bounded_queue.h"
#include "common/mesh.h"
#include "server/ingest/border_table.h"
#include "server/ingest/mesh_welder.h"
#include "server/ingest/number_table.h"

namespace lode::ingest {

/// Lists the border vertices of leaves in a border table: those on an edge that the leaf does not use exactly
/// twice, with their share of the computed normals. Works in a thread of its own, a few leaves behind its
/// caller, where it may. The table is the finder's until finish() returns.
class BorderFinder {
 public:
  BorderFinder(BorderTable& table, AttributeSet attributes, bool in_own_thread);
  ~BorderFinder();
  BorderFinder(const BorderFinder&) = delete;
  BorderFinder& operator=(const BorderFinder&) = delete;

  /// @param leaf     its number; leaves come in rising order.
  /// @param records  soup; copied where the work is done later.
  void add(uint32_t leaf, std::span<const std::byte> records);
  /// Ends when all leaves are in the table. @throws what listing them threw.
  void finish();

 private:
  struct Leaf {
    uint32_t number;
    std::vector<std::byte> records;
  };
  void list(uint32_t leaf, std::span<const std::byte> records);
  void listInOwnThread() noexcept;
  void stop() noexcept;

  BorderTable& table_;
  const AttributeSet attributes_;
  MeshWelder welder_;
  NumberTable edges_;
  BoundedQueue<Leaf> waiting_;
  std::exception_ptr failure_;  ///< the thread's, until it is joined
  std::thread thread_;
};

}  // namespace lode::ingest
