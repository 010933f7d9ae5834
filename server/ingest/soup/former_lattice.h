#pragma once

#include <filesystem>

#include "common/lattice.h"
#include "server/ingest/soup/lattice_choice.h"

namespace lode::ingest {

/// The lattice of an earlier store. A model that is built again on the same lattice has the same bytes where
/// it has not changed.
struct FormerLattice {
  Lattice lattice;
  glm::uvec3 extent{0};  ///< largest lattice coordinates of the store
  /// Distance by which rounding to the lattice moved a vertex, at most; see errorOfSnapping().
  float snap_error_steps = 0;

  /// @throws Error kIo, kInput, kFormat, kLimit if the file is no readable store.
  static FormerLattice of(const std::filesystem::path& store);

  /// Returns true if the lattice has points for the whole model.
  bool reaches(const LatticeChoice& chosen) const noexcept;
  /// Returns true if the lattice suits a model for which `chosen` was chosen: the model lies inside the
  /// store's box, and the step is at most 1.5 times the chosen one.
  bool suits(const LatticeChoice& chosen) const noexcept;
  /// Returns the choice of this lattice for a model.
  LatticeChoice chosenFor(const LatticeChoice& chosen) const noexcept;
};

/// Returns the error of a leaf's finest LOD, rounded up to a multiple of 1/64. Its product with a lattice
/// step is exact in float, so that FormerLattice can read it from a store. An edited model nearly always has
/// the same error, so that most of its nodes stay the same.
/// @param measured_steps  largest distance by which rounding to the lattice moved a vertex.
float errorOfSnapping(double measured_steps) noexcept;

}  // namespace lode::ingest
