#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "common/codec/blob.h"
#include "common/lattice.h"
#include "common/node_key.h"
#include "server/ingest/disk/record_sorter.h"
#include "server/ingest/partition/normal_fans.h"

namespace lode::ingest {

/// A fan of a leaf, at a vertex that the leaf shares with other leaves.
struct BorderVertex {
  PositionCode position;
  /// Depth of the lowest common ancestor of all leaves that share the vertex; the vertex is locked in deeper
  /// nodes.
  uint8_t lca_depth = 0;
  /// Octahedral normal of the fan; fans that continue each other across leaves have the same normal.
  uint16_t normal = 0;
  uint16_t fan = 0;  ///< index of the fan (see NormalFans) among the leaf's fans at this position
};

/// Returns the entries at a position, one per fan. @param border  entries sorted by position.
std::span<const BorderVertex> sharedAt(std::span<const BorderVertex> border, PositionCode position) noexcept;

/// Refuses a model whose nodes near the root would lock more vertices than an LOD of a store can have
/// triangles, before hours of simplification.
/// @param locked  see BorderTable::lockedBelowRoot(). @throws Error kLimit.
void refuseTooManyLocked(const std::array<uint64_t, 8>& locked, const std::filesystem::path& input);

/// Finds the vertices that several leaves share. Collects the border vertices of all leaves and joins
/// vertices at the same position. Returns the shared vertices of each leaf, with lock depths and common
/// normals. A border vertex of a single leaf is on the model's boundary and is not locked. Call add() and
/// join() from one thread; read() is thread safe.
class BorderTable {
 public:
  /// Name of the joined table's file, which outlives a killed build.
  static constexpr std::string_view kFile = "border";

  BorderTable(const TemporaryFolder& folder, uint64_t memory_bytes);
  /// Opens a joined table that save() recorded. @throws Error kIo, kFormat.
  BorderTable(const TemporaryFolder& folder, RecordReader& record);

  /// Adds a fan at a border vertex. Add the leaves in ascending order, and the fans of a leaf in the order of
  /// listFans().
  void add(PositionCode position, const ListedFan& fan);

  /// Joins the fans of all leaves. read() works after this call.
  /// @param leaves    key of each leaf, by leaf number.
  /// @param progress  function that receives the progress; each added fan counts twice.
  void join(std::span<const NodeKey> leaves, const CreaseAngle& crease,
            const RecordSorter::Progress& progress = {});

  /// Syncs the joined table to disk and writes to `record` all that the second constructor needs.
  void save(RecordWriter& record) const;

  /// Number of leaves in the joined table.
  size_t leafCount() const noexcept { return first_of_leaf_.size() - 1; }
  /// Returns the number of locked positions in each child of the root, by octant.
  const std::array<uint64_t, 8>& lockedBelowRoot() const noexcept { return locked_below_root_; }
  /// Returns the digest of a leaf's shared vertices. @pre join() has returned.
  const Digest& digest(uint32_t leaf) const noexcept { return digests_[leaf]; }
  /// Returns a leaf's shared vertices, sorted by position and fan.
  std::vector<BorderVertex> read(uint32_t leaf) const;
  /// Bytes written to temporary files so far.
  uint64_t temporaryBytes() const noexcept { return temporary_bytes_ + joined_.size(); }

 private:
  void appendByLeaf(size_t leaves, const std::function<void()>& advance);
  void countBelowRoot(std::span<const NodeKey> leaves, std::span<const ListedFan> sharing);

  std::unique_ptr<RecordSorter> by_position_, by_leaf_;  ///< null after join()
  uint64_t temporary_bytes_ = 0;
  Spool joined_;
  std::vector<uint64_t> first_of_leaf_;
  std::vector<Digest> digests_;
  std::array<uint64_t, 8> locked_below_root_{};
};

}  // namespace lode::ingest
