#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/simplified_mesh.h"

namespace lode::ingest {

/// The computed normals of a mesh, which is simplified without them: a rung's vertex gets the mean over all
/// positions that have become it. (They follow from the surface, so that quadrics gain nothing from them.)
class CarriedNormals {
 public:
  /// Takes the normals from the mesh, which is left without attributes.
  /// @param mesh  with one wedge a position, and the position's number.
  /// @param node_depth  positions with lca_depth < node_depth keep their normals to the bit.
  CarriedNormals(NodeMesh& mesh, int node_depth);

  void giveTo(SimplifiedMesh& rung) const;

 private:
  struct Normal {
    glm::vec3 vector;
    uint16_t code;
    bool locked;
  };
  AttributeSet attributes_;
  std::vector<Normal> normals_;  ///< one a position
};

}  // namespace lode::ingest
