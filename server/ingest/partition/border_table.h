#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "common/lattice.h"
#include "common/node_key.h"
#include "server/ingest/disk/record_sorter.h"
#include "server/ingest/partition/normal_fans.h"

namespace lode::ingest {

/// What a leaf must know of one of its border vertices.
struct BorderVertex {
  PositionCode position;
  uint8_t lca_depth = 0;  ///< of the leaves that share it: locked in nodes deeper than that
  uint16_t normal = 0;    ///< octahedral, of the triangles of all those leaves that are shaded as one
  uint16_t fan = 0;       ///< of those in the leaf, the one that has this normal; see NormalFans
};

/// Of a leaf's shared vertices those at a position, one a fan. @param border  by position.
std::span<const BorderVertex> sharedAt(std::span<const BorderVertex> border, PositionCode position) noexcept;

/// The border table (design 2.3): collects what leaves list, joins it by position, and gives each leaf its
/// shared vertices with their lock depth and common normals. Vertices that one leaf alone lists are
/// boundaries: they are not locked. Collecting and joining are for one thread; read() is thread safe.
class BorderTable {
 public:
  /// Name of the joined table's file, which lasts.
  static constexpr std::string_view kFile = "border";

  BorderTable(const TemporaryFolder& folder, uint64_t memory_bytes);
  /// The joined table that save() noted. @throws Error kIo, kFormat.
  BorderTable(const TemporaryFolder& folder, RecordReader& record);

  /// @param fan  one of what listFans() gives; leaves are added in rising order, a position's fans in theirs.
  void add(PositionCode position, const ListedFan& fan);

  /// @param leaves    keys by number.
  /// @param progress  in listings that were added, each counted twice.
  void join(std::span<const NodeKey> leaves, const CreaseAngle& crease,
            const RecordSorter::Progress& progress = {});

  /// Writes the joined table to the disk for good, and notes in `record` where it is.
  void save(RecordWriter& record) const;

  /// Leaves of the joined table.
  size_t leafCount() const noexcept { return first_of_leaf_.size() - 1; }
  /// Positions on borders between the root's children, of each by its octant: what is locked in it.
  const std::array<uint64_t, 8>& lockedBelowRoot() const noexcept { return locked_below_root_; }
  /// The shared vertices of a leaf, by position and fan.
  std::vector<BorderVertex> read(uint32_t leaf) const;
  /// Written to temporary files so far.
  uint64_t temporaryBytes() const noexcept { return temporary_bytes_ + joined_.size(); }

 private:
  void countBelowRoot(std::span<const NodeKey> leaves, std::span<const ListedFan> sharing);

  std::unique_ptr<RecordSorter> by_position_, by_leaf_;  ///< gone once joined
  uint64_t temporary_bytes_ = 0;
  Spool joined_;
  std::vector<uint64_t> first_of_leaf_;
  std::array<uint64_t, 8> locked_below_root_{};
};

}  // namespace lode::ingest
