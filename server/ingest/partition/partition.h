#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "server/ingest/disk/record_sorter.h"
#include "server/ingest/disk/spool.h"
#include "server/ingest/mesh/cell_code.h"
#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/mesh/soup_triangle.h"
#include "server/ingest/partition/border_table.h"
#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

/// The leaves of the octree and their meshes.
struct Partition {
  /// Name of the meshes' file, which lasts.
  static constexpr std::string_view kLeafFile = "leaves";

  AttributeSet attributes;      ///< those of the file
  std::vector<NodeKey> leaves;  ///< in Morton order
  std::vector<uint64_t> begin;  ///< byte with which each leaf begins in `meshes`, and the end
  uint64_t triangles = 0;
  Spool meshes;  ///< putLeaf's records
  BorderTable border;

  /// A leaf's mesh; nothing is locked yet. @throws Error kFormat, kIo. Thread safe.
  NodeMesh readLeaf(uint32_t leaf) const;
  /// Writes the partition to the disk for good, and notes in `record` where it is.
  void save(RecordWriter& record) const;
  /// What save() noted. @throws Error kIo, kFormat.
  static Partition load(const TemporaryFolder& folder, AttributeSet attributes, RecordReader& record);
};

/// Stage 3: takes the sorted triangles, cuts them into leaves, welds these, and finds what they share.
/// @param sorted   finished; keys are cell codes.
Partition partition(RecordSorter& sorted, AttributeSet attributes, uint32_t triangles_per_node,
                    const CreaseAngle& crease, uint64_t memory_bytes, unsigned threads,
                    const TemporaryFolder& folder, const BuildProgress& progress);

}  // namespace lode::ingest
