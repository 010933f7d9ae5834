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

/// Leaves of the octree with their meshes.
struct Partition {
  /// Name of the file that holds the meshes. The file remains if the build is killed.
  static constexpr std::string_view kLeafFile = "leaves";

  AttributeSet attributes;      ///< attributes taken from the file
  std::vector<NodeKey> leaves;  ///< keys of the leaves, in Morton order
  /// Offset of each leaf in `meshes`; the last element is the end of the last leaf.
  std::vector<uint64_t> begin;
  std::vector<Digest> digests;  ///< digest of each leaf's mesh
  uint64_t triangles = 0;
  Spool meshes;  ///< meshes as putLeaf() writes them
  BorderTable border;

  /// Reads a leaf's mesh, without locked vertices. @throws Error kFormat, kIo. Thread safe.
  NodeMesh readLeaf(uint32_t leaf) const;
  /// Syncs the partition to disk and writes to `record` all that load() needs.
  void save(RecordWriter& record) const;
  /// Opens the partition that save() recorded. @throws Error kIo, kFormat.
  static Partition load(const TemporaryFolder& folder, AttributeSet attributes, RecordReader& record);
};

struct PartitionInput {
  RecordSorter& sorted;     ///< finished sorter with cell codes as keys
  AttributeSet attributes;  ///< attributes of the sorted triangles
  uint32_t triangles_per_node = 0;
  CreaseAngle crease;
  uint64_t memory_bytes = 0;  ///< memory for the border table
  unsigned threads = 1;
  const TemporaryFolder& folder;
  const BuildProgress& progress;
};

/// Cuts sorted triangles into leaves, welds each leaf, and finds the vertices that leaves share.
Partition partition(const PartitionInput& input);

}  // namespace lode::ingest
