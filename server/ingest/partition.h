#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "server/ingest/border_table.h"
#include "server/ingest/build.h"
#include "server/ingest/cell_code.h"
#include "server/ingest/record_sorter.h"
#include "server/ingest/soup.h"
#include "server/ingest/spool.h"

namespace lode::ingest {

/// The leaves of the octree and their triangles.
struct Partition {
  /// Name of the soup's file, which lasts.
  static constexpr std::string_view kSoupFile = "soup";

  AttributeSet attributes;      ///< of the soup: those of the file
  std::vector<NodeKey> leaves;  ///< in Morton order
  std::vector<uint64_t> first;  ///< triangle in the soup with which each leaf begins, and the end
  Spool soup;                   ///< storeSoup's records, leaf by leaf
  BorderTable border;

  /// A leaf's records. Thread safe.
  std::vector<std::byte> readLeaf(uint32_t leaf) const;
  /// Writes the partition to the disk for good, and notes in `record` where it is.
  void save(RecordWriter& record) const;
  /// What save() noted. @throws Error kIo, kFormat.
  static Partition load(const TemporaryFolder& folder, AttributeSet attributes, RecordReader& record);
  uint64_t triangleCount() const noexcept { return first.back(); }
};

/// Stage 3: takes the sorted triangles, cuts them into leaves, and finds what the leaves share.
/// @param sorted   finished; keys are cell codes.
/// @param threads  two are used where there are more.
Partition partition(RecordSorter& sorted, AttributeSet attributes, uint32_t triangles_per_node,
                    uint64_t memory_bytes, unsigned threads, const TemporaryFolder& folder,
                    const BuildProgress& progress);

}  // namespace lode::ingest
