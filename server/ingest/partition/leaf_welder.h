#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <vector>

#include "common/codec/blob.h"
#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/partition/border_table.h"
#include "server/ingest/threads/in_order.h"

namespace lode::ingest {

/// Welds the triangles of each leaf into a mesh. Adds the leaf's border vertices to a border table, each
/// with its fan, the triangles that give its normal. A border vertex lies on an edge that has one triangle of
/// the leaf, or more than two. Do not use the table elsewhere until finish() has returned.
class LeafWelder {
 public:
  /// A function that receives each leaf's mesh as putLeaf() wrote it, and the mesh's digest, in the order of
  /// add().
  using Sink = std::function<void(std::span<const std::byte> mesh, const Digest& digest)>;

  /// @param helpers  threads that weld in parallel with the caller. @param sink  add() and finish() call the
  /// sink.
  LeafWelder(BorderTable& table, AttributeSet attributes, const CreaseAngle& crease, Helpers& helpers,
             Sink sink);

  /// Welds a leaf, in the background if a thread is free.
  /// @param leaf  number of the leaf; call add() in ascending order of leaves.
  /// @param records  triangles of the leaf; add() copies the records.
  void add(uint32_t leaf, std::span<const std::byte> records);
  /// Waits until all leaves are in the table. Like add(), rethrows exceptions of welding.
  void finish() { welded_.finish(); }

 private:
  struct Welded {
    uint32_t leaf = 0;
    RecordWriter mesh;
    Digest digest;
    std::vector<PositionCode> border;
    std::vector<std::vector<ListedFan>> fans;  ///< fans of the leaf, one list per border position
  };
  Welded weld(uint32_t leaf, std::span<const std::byte> records);
  NodeMesh weld(std::span<const std::byte> records);

  const AttributeSet attributes_;
  const CreaseAngle crease_;
  std::mutex mutex_;                 ///< guards welders_
  std::vector<MeshWelder> welders_;  ///< idle welders, for reuse
  InOrder<Welded> welded_;
};

}  // namespace lode::ingest
