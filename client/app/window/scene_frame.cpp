#include "client/app/window/scene_frame.h"

#include <algorithm>
#include <cmath>

#include <glm/glm.hpp>

namespace lode::app {

Lattice latticeWithRoom(const ModelSummary& whole, std::span<const SceneInstance> instances) {
  glm::dvec3 min = whole.lattice.toWorld(whole.box.min), max = whole.lattice.toWorld(whole.box.max);
  for (const SceneInstance& instance : instances) {
    min = glm::min(min, instance.placement.position);
    max = glm::max(max, instance.placement.position);
  }
  const double longest = std::max({max.x - min.x, max.y - min.y, max.z - min.z, whole.lattice.step});
  return {min - longest, std::exp2(std::ceil(std::log2(3 * longest / kMaxLattice)))};
}

LatticeBox boxIn(const Lattice& lattice, const ModelSummary& whole) {
  LatticeBox box;
  box.add(lattice.snap(whole.lattice.toWorld(whole.box.min)));
  box.add(lattice.snap(whole.lattice.toWorld(whole.box.max)));
  return box;
}

}  // namespace lode::app
