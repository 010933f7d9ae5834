#include "server/ingest/soup/former_lattice.h"

#include <algorithm>
#include <cmath>

#include "server/store/reader.h"

namespace lode::ingest {
namespace {

constexpr double kUpperBound = 1.0001;  ///< factor that keeps an error an upper bound despite rounding
constexpr double kErrorsPerStep = 64;
const float kMostError = errorOfSnapping(std::sqrt(0.75));  ///< half of a lattice cell's diagonal
constexpr double kMostCoarser = 1.5;

}  // namespace

float errorOfSnapping(double measured_steps) noexcept {
  return static_cast<float>(std::ceil(kUpperBound * measured_steps * kErrorsPerStep) / kErrorsPerStep);
}

FormerLattice FormerLattice::of(const std::filesystem::path& store) {
  const store::Reader reader(store);
  const ModelSummary& summary = reader.summary();
  const auto leaf = std::ranges::find_if(reader.nodes(), [](const Node& node) { return node.isLeaf(); });
  const auto error_steps = static_cast<float>(leaf->lods.front().error_model / summary.lattice.step);
  // The leaf of a preview has a larger error, because its vertices are clustered.
  return {summary.lattice, summary.box.max, error_steps <= kMostError ? error_steps : 0};
}

bool FormerLattice::reaches(const LatticeChoice& chosen) const noexcept {
  return glm::all(glm::greaterThanEqual(chosen.min, lattice.origin)) &&
         glm::all(glm::lessThanEqual(chosen.max, lattice.toWorld(glm::uvec3(kMaxLattice))));
}

bool FormerLattice::suits(const LatticeChoice& chosen) const noexcept {
  return reaches(chosen) && lattice.step <= kMostCoarser * chosen.lattice.step &&
         glm::all(glm::lessThanEqual(chosen.max, lattice.toWorld(extent)));
}

LatticeChoice FormerLattice::chosenFor(const LatticeChoice& chosen) const noexcept {
  LatticeChoice choice = chosen;
  choice.lattice = lattice;
  choice.extent = glm::max(extent, lattice.snap(chosen.max));
  choice.least_snap_error_steps = snap_error_steps;
  return choice;
}

}  // namespace lode::ingest
