#include "server/ingest/simplify/cluster_tree.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "server/ingest/mesh/cell_code.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kAbove = 64;  // a level above the levels of all cells

// Returns the level of the smallest cell that contains both codes.
uint32_t commonLevel(uint64_t a, uint64_t b) noexcept {
  return (static_cast<uint32_t>(std::bit_width(a ^ b)) + 2) / 3;
}

}  // namespace

ClusterTree::ClusterTree(const CollapseMesh& mesh)
    : cell_of_(mesh.positions.size(), kNone), codes_(mesh.positions.size()) {
  const uint32_t count = static_cast<uint32_t>(mesh.positions.size());
  glm::dvec3 low(kMaxLattice);
  std::vector<Entry> entries;
  entries.reserve(count);
  for (uint32_t i = 0; i < count; ++i) {
    if (mesh.positions[i].locked) continue;
    low = glm::min(low, mesh.point(i));
    entries.push_back({0, i});
  }
  for (Entry& entry : entries) {
    const glm::uvec3 p(mesh.point(entry.position) - low);
    entry.code = spreadBits(p.x) | spreadBits(p.y) << 1 | spreadBits(p.z) << 2;
    codes_[entry.position] = entry.code;
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.code < b.code; });
  build(entries);
  for (Cell& cell : cells_) {
    const double side = static_cast<double>(uint64_t{1} << cell.level);
    cell.corner = low + side * glm::floor((mesh.point(cell.a_position) - low) / side);
  }
}

// Builds the cells in one pass over the positions in Morton order. `open` is a stack of nested cells that can
// still receive positions. The common level of two consecutive positions tells which of these cells end,
// because they do not contain the second position.
void ClusterTree::build(const std::vector<Entry>& entries) {
  std::vector<uint32_t> open;
  for (size_t i = 0; i < entries.size(); ++i) {
    const uint32_t level =
        i + 1 < entries.size() ? commonLevel(entries[i].code, entries[i + 1].code) : kAbove;
    uint32_t closed = kNone;
    const auto putInto = [&](uint32_t cell) {
      (closed == kNone ? cell_of_[entries[i].position] : cells_[closed].parent) = cell;
    };
    while (!open.empty() && cells_[open.back()].level < level) {
      putInto(open.back());
      closed = open.back();
      order_.push_back(closed);
      open.pop_back();
    }
    if (level == kAbove) break;
    if (open.empty() || cells_[open.back()].level != level) {
      open.push_back(static_cast<uint32_t>(cells_.size()));
      cells_.push_back({kNone, level, glm::dvec3(0), entries[i].position});
    }
    putInto(open.back());
  }
}

uint32_t ClusterTree::commonOfTwo(uint32_t a, uint32_t b, uint32_t c) const noexcept {
  uint32_t from = kNone, least = kAbove;
  const auto consider = [&](uint32_t one, uint32_t other) {
    if (cell_of_[one] == kNone || cell_of_[other] == kNone) return;
    const uint32_t level = commonLevel(codes_[one], codes_[other]);
    if (level < least) {
      least = level;
      from = cell_of_[one];
    }
  };
  consider(a, b);
  consider(b, c);
  consider(c, a);
  if (from == kNone) return kNone;
  while (cells_[from].level < least) from = cells_[from].parent;
  return from;
}

uint32_t ClusterTree::common(uint32_t a, uint32_t b) const noexcept {
  uint32_t cell = cell_of_[a];
  if (cell == kNone || cell_of_[b] == kNone) return kNone;
  const uint32_t level = commonLevel(codes_[a], codes_[b]);
  while (cells_[cell].level < level) cell = cells_[cell].parent;
  return cell;
}

ClusterWedges::ClusterWedges(const CollapseMesh& mesh, const ClusterTree& tree)
    : first_(tree.cells().size() + 1), root_(mesh.wedges.size()) {
  reset();
  if (!mesh.hasWedges()) return;
  // For each corner, the smallest cell that contains the triangle edge starting at the corner.
  std::vector<uint32_t> cells(mesh.corner_position.size(), ClusterTree::kNone);
  for (uint32_t c = 0; c < cells.size(); ++c) {
    if ((c & 3) == 3) continue;
    cells[c] = tree.common(mesh.at(c), mesh.at(CollapseMesh::next(c)));
    if (cells[c] != ClusterTree::kNone) ++first_[cells[c] + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  links_.resize(first_.back());
  std::vector<uint32_t> end(first_.begin(), first_.end() - 1);
  for (uint32_t c = 0; c < cells.size(); ++c) {
    if (cells[c] == ClusterTree::kNone) continue;
    links_[end[cells[c]]++] = {mesh.corner_wedge[c], mesh.corner_wedge[CollapseMesh::next(c)]};
  }
}

uint32_t ClusterWedges::find(uint32_t wedge) noexcept {
  while (root_[wedge] != wedge) {
    root_[wedge] = root_[root_[wedge]];
    wedge = root_[wedge];
  }
  return wedge;
}

void ClusterWedges::reset() { std::iota(root_.begin(), root_.end(), 0u); }

}  // namespace lode::ingest
