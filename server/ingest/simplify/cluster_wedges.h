#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/ingest/simplify/cluster_tree.h"
#include "server/ingest/simplify/wedge_quadrics.h"

namespace lode::ingest {

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
