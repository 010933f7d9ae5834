#include "client/app/window/scene/scene_frame.h"

#include <algorithm>
#include <cmath>

#include <glm/glm.hpp>

namespace lode::app {
namespace {

constexpr double kRoom = 64;  ///< on each side, in longest sides of what is there

}  // namespace

Lattice latticeWithRoom(const ModelSummary& whole) {
  const glm::dvec3 min = whole.lattice.toWorld(whole.box.min), max = whole.lattice.toWorld(whole.box.max);
  const double longest = std::max({max.x - min.x, max.y - min.y, max.z - min.z, whole.lattice.step});
  return {min - kRoom * longest, std::exp2(std::ceil(std::log2((2 * kRoom + 1) * longest / kMaxLattice)))};
}

LatticeBox boxIn(const Lattice& lattice, const ModelSummary& whole) {
  LatticeBox box;
  box.add(lattice.snap(whole.lattice.toWorld(whole.box.min)));
  box.add(lattice.snap(whole.lattice.toWorld(whole.box.max)));
  return box;
}

}  // namespace lode::app
