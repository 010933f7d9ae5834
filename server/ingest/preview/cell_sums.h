#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "common/mesh.h"
#include "server/ingest/preview/cluster_grid.h"
#include "server/ingest/simplify/quadric.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

/// Sums over the vertices and triangles of each cell of a grid, from which the cell's vertex follows.
class CellSums {
 public:
  /// Adds all vertices of the input.
  CellSums(const PackedInput& input, const ClusterGrid& grid);

  /// Returns the attributes of the cells' vertices: those of the input without textures, and normals.
  AttributeSet attributes() const noexcept { return attributes_; }
  /// Adds a triangle to the cells of its corners, unless it has no area. @param colour  colour of the face,
  /// or null.
  void addTriangle(const ClusterGrid& grid, glm::u32vec3 vertices, glm::u32vec3 cells,
                   const glm::u8vec4* colour);
  /// Returns the lattice point in the cell that fits the cell's triangles best.
  glm::uvec3 pointOf(const ClusterGrid& grid, uint32_t cell) const;
  VertexAttributes attributesOf(uint32_t cell) const;

 private:
  struct Sum {
    Quadric quadric;       ///< planes of the triangles, relative to the cell's corner
    glm::dvec3 point{0};   ///< vertices, relative to the cell's corner
    glm::dvec3 normal{0};  ///< normals of vertices, or of triangles by area if vertices have none
    glm::u64vec4 colour{0};
    uint32_t points = 0, colours = 0;
  };

  AttributeSet attributes_;
  bool has_vertex_normals_;
  std::vector<Sum> sums_;
};

}  // namespace lode::ingest
