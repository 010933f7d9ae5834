#pragma once

#include "common/lattice.h"
#include "common/mesh.h"

namespace lode {

/// Makes a triangle that spans the whole lattice.
inline Mesh wideTriangle(uint8_t attributes = 0) {
  Mesh mesh;
  mesh.attributes.bits = attributes;
  for (const glm::uvec3 p : {glm::uvec3(0, 1, 2), glm::uvec3(4, 5, 6), glm::uvec3(kMaxLattice)})
    mesh.positions.push_back(packPosition(p));
  mesh.triangles = {{0, 2, 1}};
  if (attributes != 0) mesh.vertex_attributes.resize(3);
  return mesh;
}

}  // namespace lode
