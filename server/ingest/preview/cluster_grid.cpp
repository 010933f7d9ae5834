#include "server/ingest/preview/cluster_grid.h"

#include <algorithm>
#include <bit>

#include "server/ingest/mesh/number_table.h"

namespace lode::ingest {
namespace {

/// Largest number of cells along an axis with which the search for the width begins. A surface that spans
/// more cells occupies too many of them.
constexpr uint32_t kMostCellsAcross = 1024;

}  // namespace

ClusterGrid::ClusterGrid(const PackedInput& input, const Lattice& lattice, glm::uvec3 extent,
                         uint32_t max_cells) {
  positions_.reserve(input.vertexCount());
  input.readVertices(0, input.vertexCount(), [&](uint64_t, glm::dvec3 position, const VertexAttributes&) {
    positions_.push_back(packPosition(lattice.snap(position)));
  });
  cells_.resize(positions_.size());
  const uint32_t longest = std::max({extent.x, extent.y, extent.z});
  if (positions_.size() > max_cells)
    while (longest >> shift_ > kMostCellsAcross) ++shift_;
  while (!assign(max_cells)) ++shift_;
}

void ClusterGrid::coarsen() {
  ++shift_;
  assign(cellCount());  // coarsening never adds cells
}

/// Assigns each vertex to its cell. @return false if there are more than `max_cells` cells.
bool ClusterGrid::assign(uint32_t max_cells) {
  corners_.clear();
  NumberTable numbers;
  numbers.reset(std::min<size_t>(positions_.size(), max_cells));
  uint64_t last_key = UINT64_MAX;  // skips the search for vertices in the cell of the previous vertex
  uint32_t last_cell = 0;
  for (size_t vertex = 0; vertex < positions_.size(); ++vertex) {
    const glm::uvec3 cell = unpackPosition(positions_[vertex]) >> shift_;
    const uint64_t key = packPosition(cell).value;
    if (key != last_key) {
      last_key = key;
      last_cell = numbers.findOrAdd(key, cellCount());
      if (last_cell == cellCount()) {
        if (last_cell == max_cells) return false;
        corners_.push_back(cell << shift_);
      }
    }
    cells_[vertex] = last_cell;
  }
  return true;
}

}  // namespace lode::ingest
