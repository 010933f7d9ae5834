#pragma once

#include <vector>

#include "common/lattice.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

/// Step of a model's lattice: the largest power of two that is at most 1/16 of the 5th-percentile edge, but
/// coarse enough that the box fits 21 bits and that double holds the coordinates. See docs/store-format.md.
/// @param edges  lengths of a sample of edges, true units; zero lengths are left out; changed (partly
/// sorted).
double chooseStep(std::vector<double>& edges, glm::dvec3 box_min, glm::dvec3 box_max);

struct LatticeChoice {
  Lattice lattice;
  glm::uvec3 extent{0};  ///< largest lattice coordinates of the referenced vertices
};

/// The second look: the box of the vertices that faces use (a stray vertex must not cost precision), and edge
/// lengths from evenly spread faces.
/// @throws Error kInput if all used vertices coincide.
LatticeChoice chooseLattice(const PackedInput& input, const std::filesystem::path& name);

}  // namespace lode::ingest
