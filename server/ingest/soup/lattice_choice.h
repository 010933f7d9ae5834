#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "common/lattice.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

/// Chooses the step of a model's lattice: the largest valid step (see isLatticeStep()) that is at most 1/32
/// of the 5th percentile of edge lengths and at most 1/4096 of the box's longest side. Chooses a larger step
/// if the box would otherwise exceed 21 bits per axis, or double could not represent the coordinates exactly.
/// See docs/store-format.md.
/// @param edges  lengths of sampled edges, in model units. The function ignores zeros and reorders the
/// vector.
double chooseStep(std::vector<double>& edges, glm::dvec3 box_min, glm::dvec3 box_max);

/// First four corners of a sampled face. The fourth corner of a triangle repeats its first corner.
using SampledFace = std::array<uint32_t, 4>;
SampledFace sampledFace(std::span<const uint32_t> corners);
/// Returns n if every n-th face of a model is sampled. Returns 1 for models with fewer than 2^18 faces.
uint64_t faceStride(uint64_t faces) noexcept;

/// Returns the position of a vertex, in model units.
using PositionOf = std::function<glm::dvec3(uint32_t vertex)>;

/// Returns true if a face has at least three sides of positive length, and the ends of one of them coincide
/// on the lattice.
bool isLost(std::span<const uint32_t> corners, const PositionOf& position_of, const Lattice& lattice);

/// Chooses the lattice. Starts with chooseStep() and halves the step until at most a millionth of the sampled
/// faces is lost, or no more than on the finest possible lattice. The origin is a multiple of the step.
Lattice chooseLattice(std::span<const SampledFace> faces, const PositionOf& position_of, glm::dvec3 box_min,
                      glm::dvec3 box_max);

/// Data of the vertices that faces use. Only these vertices determine the lattice, so that stray unused
/// vertices do not reduce its precision.
struct UsedVertices {
  uint64_t count = 0;
  glm::dvec3 min{std::numeric_limits<double>::max()}, max{std::numeric_limits<double>::lowest()};  ///< box
  std::vector<SampledFace> faces;     ///< sampled faces, whose corners are indices of `positions`
  std::vector<glm::dvec3> positions;  ///< corners of the sampled faces
  bool coincide() const noexcept { return !glm::any(glm::lessThan(min, max)); }
};
UsedVertices findUsedVertices(const PackedInput& input);

/// A lattice, or the reason why no lattice is suitable, with the remedy.
struct LatticeOrProblem {
  std::optional<Lattice> lattice;
  std::string_view problem;
};
LatticeOrProblem chooseLattice(const UsedVertices& used);

struct LatticeChoice {
  Lattice lattice;
  glm::uvec3 extent{0};       ///< largest lattice coordinates of the used vertices
  glm::dvec3 min{0}, max{0};  ///< box of the used vertices in the file
  /// Smallest value for errorOfSnapping() of the model; more than 0 on the lattice of an earlier store.
  float least_snap_error_steps = 0;
};

/// Chooses the lattice of a packed input. @param name  path for messages. @param most_step_model  step to
/// use, rounded down to a valid one; 0: chooses the step. @throws Error kInput if no lattice is suitable.
LatticeChoice chooseLattice(const PackedInput& input, const std::filesystem::path& name,
                            double most_step_model = 0);

}  // namespace lode::ingest
