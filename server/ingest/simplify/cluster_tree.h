#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/wedge_quadrics.h"

namespace lode::ingest {

/// The cells of an octree over a mesh's unlocked positions that hold more than one of them and in which more
/// than one child has some.
class ClusterTree {
 public:
  static constexpr uint32_t kNone = ~0u;

  struct Cell {
    uint32_t parent = kNone;
    uint32_t level = 0;       ///< its side is 2^level steps
    glm::dvec3 corner{0};     ///< the lowest, relative to the mesh's origin
    uint32_t a_position = 0;  ///< one of those within
  };

  explicit ClusterTree(const CollapseMesh& mesh);

  const std::vector<Cell>& cells() const noexcept { return cells_; }
  /// Cells, each after those within it.
  const std::vector<uint32_t>& order() const noexcept { return order_; }
  /// The smallest cell around a position; kNone for locked ones, and where the tree is empty.
  uint32_t cellOf(uint32_t position) const noexcept { return cell_of_[position]; }
  /// The smallest cell around both; kNone if one is in no cell.
  uint32_t common(uint32_t a, uint32_t b) const noexcept;
  /// The smallest cell around two of three; kNone if there is none.
  uint32_t commonOfTwo(uint32_t a, uint32_t b, uint32_t c) const noexcept;

 private:
  struct Entry {
    uint64_t code;
    uint32_t position;
  };
  void build(const std::vector<Entry>& entries);

  std::vector<Cell> cells_;
  std::vector<uint32_t> order_;
  std::vector<uint32_t> cell_of_;  ///< a position
  std::vector<uint64_t> codes_;    ///< a position, Morton
};

/// Which wedges become one as the cells of a tree do: those that an edge of a triangle connects within the
/// cell. (A seam's two sides stay two wedges.)
class ClusterWedges {
 public:
  struct Link {
    uint32_t a, b;  ///< wedges
  };

  ClusterWedges(const CollapseMesh& mesh, const ClusterTree& tree);

  /// Links that lie within a cell and in none of those within it.
  std::span<const Link> linksOf(uint32_t cell) const noexcept {
    return {links_.data() + first_[cell], first_[cell + 1] - first_[cell]};
  }
  uint32_t find(uint32_t wedge) noexcept;
  /// Joins the wedges of a cell's links, calling joined(keep, gone) for each that ends.
  template <typename Joined>
  void joinCell(uint32_t cell, Joined&& joined) {
    for (const Link& link : linksOf(cell)) {
      const uint32_t a = find(link.a), b = find(link.b);
      if (a == b) continue;
      joined(std::min(a, b), std::max(a, b));
      root_[std::max(a, b)] = std::min(a, b);
    }
  }
  /// Parts all wedges again.
  void reset();

 private:
  std::vector<Link> links_;      ///< by cell
  std::vector<uint32_t> first_;  ///< a cell's in links_, and one more
  std::vector<uint32_t> root_;   ///< a wedge; never above it
};

}  // namespace lode::ingest
