#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <vector>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/partition/border_table.h"
#include "server/ingest/threads/in_order.h"

namespace lode::ingest {

/// Makes meshes of leaves' soup, and lists their border vertices in a border table: those on an edge that the
/// leaf does not use exactly twice, with their share of the computed normals. The table is the welder's until
/// finish() returns.
class LeafWelder {
 public:
  /// Takes each leaf's mesh, as putLeaf() has written it, in the order in which leaves came.
  using Sink = std::function<void(std::span<const std::byte> mesh)>;

  /// @param helpers  weld beside the caller. @param sink  called by add() and finish().
  LeafWelder(BorderTable& table, AttributeSet attributes, const CreaseAngle& crease, Helpers& helpers,
             Sink sink);

  /// @param leaf     its number; leaves come in rising order.
  /// @param records  soup; copied.
  void add(uint32_t leaf, std::span<const std::byte> records);
  /// Ends when all leaves are in the table. @throws what welding them threw, as add() does.
  void finish() { welded_.finish(); }

 private:
  struct Welded {
    uint32_t leaf = 0;
    RecordWriter mesh;
    std::vector<PositionCode> border;
    std::vector<std::vector<ListedFan>> fans;  ///< a list a border position
  };
  Welded weld(uint32_t leaf, std::span<const std::byte> records);
  NodeMesh weld(std::span<const std::byte> records);

  const AttributeSet attributes_;
  const CreaseAngle crease_;
  std::mutex mutex_;                 ///< of welders_
  std::vector<MeshWelder> welders_;  ///< that no leaf uses now
  InOrder<Welded> welded_;
};

}  // namespace lode::ingest
