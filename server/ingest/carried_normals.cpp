#include "server/ingest/carried_normals.h"

#include "common/octahedral.h"

namespace lode::ingest {

CarriedNormals::CarriedNormals(NodeMesh& mesh, int node_depth) : attributes_(mesh.attributes) {
  normals_.reserve(mesh.positions.size());
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const uint16_t code = mesh.wedge_attributes[i].normal;
    normals_.push_back({decodeOctahedral(code), code, mesh.lca_depth[i] < node_depth});
  }
  mesh.attributes = {};
  mesh.wedge_attributes = {};
}

void CarriedNormals::giveTo(SimplifiedMesh& rung) const {
  struct Sum {
    glm::vec3 vector{0};
    uint16_t code = 0;
    bool mixed = false, locked = false, found = false;
  };
  std::vector<Sum> sums(rung.mesh.positions.size());
  for (size_t i = 0; i < normals_.size(); ++i) {
    if (rung.became[i] == kVanished) continue;
    Sum& sum = sums[rung.became[i]];
    const Normal& normal = normals_[i];
    sum.vector += normal.vector;
    if (sum.locked) continue;
    sum.mixed = sum.found && !normal.locked;
    sum.found = true;
    sum.locked = normal.locked;
    sum.code = normal.code;
  }
  constexpr float kShortest = 1e-3f;
  rung.mesh.attributes = attributes_;
  rung.mesh.wedge_attributes.resize(sums.size());
  for (size_t i = 0; i < sums.size(); ++i) {
    const float length = glm::length(sums[i].vector);
    const bool exact = !sums[i].mixed || length < kShortest;
    rung.mesh.wedge_attributes[i].normal = exact ? sums[i].code : encodeOctahedral(sums[i].vector / length);
  }
}

}  // namespace lode::ingest
