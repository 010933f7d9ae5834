#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "common/codec/texture_set.h"
#include "common/mesh.h"

namespace lode::tiles {

/// A connected part of a mesh: triangles that share vertices, so that the part is also connected in the
/// texture.
struct Chart {
  uint16_t material = 0;
  glm::dvec2 least{0}, most{0};  ///< box of the true texture coordinates
  double area_uv = 0;            ///< area in the texture; the whole image has area 1
  double area_model = 0;         ///< area on the surface, in square model units
};

struct Charts {
  std::vector<Chart> charts;        ///< in the order of their first vertices
  std::vector<uint32_t> of_vertex;  ///< index of each vertex's chart
};

/// Finds the charts of a mesh with texture coordinates. Each vertex belongs to one chart. @param step  step
/// of the lattice. Thread safe.
Charts findCharts(const Mesh& mesh, const TextureSet& textures, double step);

}  // namespace lode::tiles
