#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "common/mesh.h"
#include "server/ingest/preview/cluster_grid.h"
#include "server/ingest/preview/face_triangles.h"
#include "server/ingest/preview/texture_colours.h"
#include "server/ingest/simplify/quadric.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

/// Sums over the vertices and triangles of each cell of a grid. These determine the cell's vertex in the
/// clustered mesh.
class CellSums {
 public:
  /// Memory per vertex of a textured input.
  static constexpr uint64_t kTexturedVertexBytes = sizeof(glm::u16vec2);

  /// Adds all vertices of the input. @param textures  colours of the input's images; must outlive this
  /// object.
  CellSums(const PackedInput& input, const ClusterGrid& grid, const TextureColours& textures);

  /// Returns the attributes of the cells' vertices: the input's attributes and normals, with colours in place
  /// of textures.
  AttributeSet attributes() const noexcept { return attributes_; }
  /// Adds a triangle to the cells of its corners, unless it has no area. @param place  place in `block`.
  void addTriangle(const ClusterGrid& grid, glm::u32vec3 vertices, glm::u32vec3 cells,
                   const PackedInput::FaceBlock& block, const TrianglePlace& place);
  /// Returns the lattice point in the cell that fits the cell's triangles best.
  glm::uvec3 pointOf(const ClusterGrid& grid, uint32_t cell) const;
  VertexAttributes attributesOf(uint32_t cell) const;

 private:
  struct Sum {
    Quadric quadric;       ///< planes of the triangles, relative to the cell's corner
    glm::dvec3 point{0};   ///< vertices, relative to the cell's corner
    glm::dvec3 normal{0};  ///< normals of vertices, or of triangles by area if vertices have none
    glm::u64vec4 colour{0};
    glm::u64vec3 texel{0};
    uint32_t points = 0, colours = 0, texels = 0;
  };
  void addTexels(glm::u32vec3 vertices, glm::u32vec3 cells, const PackedInput::FaceBlock& block,
                 const TrianglePlace& place);

  AttributeSet attributes_;
  bool has_vertex_normals_;
  const TextureColours& textures_;
  std::vector<glm::u16vec2> texture_of_vertex_;  ///< empty unless vertices have texture coordinates
  std::vector<Sum> sums_;
};

}  // namespace lode::ingest
