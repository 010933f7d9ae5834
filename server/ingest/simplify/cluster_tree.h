#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/wedge_quadrics.h"

namespace lode::ingest {

/// Octree over a mesh's unlocked positions, that is, those that may move. The octree contains only cells with
/// positions in at least two of their octants.
class ClusterTree {
 public:
  static constexpr uint32_t kNone = ~0u;

  struct Cell {
    uint32_t parent = kNone;
    uint32_t level = 0;       ///< the cell's side is 2^level lattice steps long
    glm::dvec3 corner{0};     ///< minimum corner, relative to the mesh's origin
    uint32_t a_position = 0;  ///< any position inside the cell
  };

  explicit ClusterTree(const CollapseMesh& mesh);

  const std::vector<Cell>& cells() const noexcept { return cells_; }
  /// Returns all cells, children before parents.
  const std::vector<uint32_t>& order() const noexcept { return order_; }
  /// Returns the smallest cell that contains a position; kNone if the position is locked or the tree is
  /// empty.
  uint32_t cellOf(uint32_t position) const noexcept { return cell_of_[position]; }
  /// Returns the smallest cell that contains both positions; kNone if one of them is in no cell.
  uint32_t common(uint32_t a, uint32_t b) const noexcept;
  /// Returns the smallest cell that contains two of the three positions; kNone if no cell does.
  uint32_t commonOfTwo(uint32_t a, uint32_t b, uint32_t c) const noexcept;

 private:
  struct Entry {
    uint64_t code;
    uint32_t position;
  };
  void build(const std::vector<Entry>& entries);

  std::vector<Cell> cells_;
  std::vector<uint32_t> order_;
  std::vector<uint32_t> cell_of_;  ///< for each position, the smallest cell that contains it
  std::vector<uint64_t> codes_;    ///< Morton code of each position
};

/// Finds the wedges (sets of attributes at a position) that merge when a cell merges. Two wedges merge if a
/// triangle edge inside the cell connects them, so the two sides of a seam stay separate.
class ClusterWedges {
 public:
  struct Link {
    uint32_t a, b;  ///< wedges at the two ends of an edge
  };

  ClusterWedges(const CollapseMesh& mesh, const ClusterTree& tree);

  /// Returns the links inside a cell that do not lie inside one of its child cells.
  std::span<const Link> linksOf(uint32_t cell) const noexcept {
    return {links_.data() + first_[cell], first_[cell + 1] - first_[cell]};
  }
  /// Returns the wedge that represents all wedges merged with `wedge`.
  uint32_t find(uint32_t wedge) noexcept;
  /// Merges the wedges of a cell's links. Calls joined(keep, gone) once per merge.
  template <typename Joined>
  void joinCell(uint32_t cell, Joined&& joined) {
    for (const Link& link : linksOf(cell)) {
      const uint32_t a = find(link.a), b = find(link.b);
      if (a == b) continue;
      joined(std::min(a, b), std::max(a, b));
      root_[std::max(a, b)] = std::min(a, b);
    }
  }
  /// Separates all wedges again.
  void reset();

 private:
  std::vector<Link> links_;      ///< sorted by cell
  std::vector<uint32_t> first_;  ///< index of each cell's first link; the last element is the number of links
  /// Union-find parent of each wedge. The parent's index is never larger than the wedge's index.
  std::vector<uint32_t> root_;
};

}  // namespace lode::ingest
