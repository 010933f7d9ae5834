#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/ingest/border_table.h"
#include "server/ingest/in_order.h"
#include "server/ingest/mesh_welder.h"
#include "server/ingest/number_table.h"

namespace lode::ingest {

/// Lists the border vertices of leaves in a border table: those on an edge that the leaf does not use exactly
/// twice, with their share of the computed normals. The table is the finder's until finish() returns.
class BorderFinder {
 public:
  /// @param threads  with more than one, leaves are looked at on so many, beside the caller.
  BorderFinder(BorderTable& table, AttributeSet attributes, unsigned threads);

  /// @param leaf     its number; leaves come in rising order.
  /// @param records  soup; copied where the work is done later.
  void add(uint32_t leaf, std::span<const std::byte> records);
  /// Ends when all leaves are in the table. @throws what looking at them threw, as add() does.
  void finish() { found_.finish(); }

 private:
  struct Found {
    uint32_t leaf = 0;
    std::vector<PositionCode> positions;
    std::vector<glm::i64vec3> normals;  ///< one a position
  };
  /// What looking at a leaf takes.
  struct Desk {
    MeshWelder welder;
    NumberTable edges;
  };
  Found find(uint32_t leaf, std::span<const std::byte> records, Desk& desk) const;

  const AttributeSet attributes_;
  std::vector<Desk> desks_;  ///< leaves take turns at them
  size_t next_desk_ = 0;
  InOrder<Found> found_;
};

}  // namespace lode::ingest
