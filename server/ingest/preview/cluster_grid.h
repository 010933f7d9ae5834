#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/lattice.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

/// Assigns the vertices of a model to the cells of a cubic grid, whose cells are 2^shift lattice steps wide.
/// Cells are numbered in the order of their first vertices.
class ClusterGrid {
 public:
  /// Memory per vertex of the input.
  static constexpr uint64_t kVertexBytes = sizeof(PositionCode) + sizeof(uint32_t);

  /// Snaps all vertices, and chooses the smallest cell width at which at most `max_cells` cells contain
  /// vertices.
  /// @param extent  largest lattice coordinates. @param input  must be flushed.
  ClusterGrid(const PackedInput& input, const Lattice& lattice, glm::uvec3 extent, uint32_t max_cells);

  /// Doubles the width of the cells.
  void coarsen();

  uint32_t cellCount() const noexcept { return static_cast<uint32_t>(corners_.size()); }
  uint32_t cellOf(uint32_t vertex) const noexcept { return cells_[vertex]; }
  glm::uvec3 positionOf(uint32_t vertex) const noexcept { return unpackPosition(positions_[vertex]); }
  /// Returns true if two corners of a triangle have the same lattice point. The build drops such triangles.
  bool coincide(glm::u32vec3 t) const noexcept {
    return positions_[t.x] == positions_[t.y] || positions_[t.y] == positions_[t.z] ||
           positions_[t.z] == positions_[t.x];
  }
  /// Returns the smallest lattice point of a cell. @param cell  smaller than cellCount().
  glm::uvec3 cornerOf(uint32_t cell) const noexcept { return corners_[cell]; }
  /// Returns the width of the cells in lattice steps.
  uint32_t widthSteps() const noexcept { return 1u << shift_; }

 private:
  bool assign(uint32_t max_cells);

  std::vector<PositionCode> positions_;
  std::vector<uint32_t> cells_;  ///< cell of each vertex
  std::vector<glm::uvec3> corners_;
  uint32_t shift_ = 0;
};

}  // namespace lode::ingest
