#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "common/lattice.h"

namespace lode::ingest {

/// Counts of the triangles that a build drops because corners that are distinct in the file coincide on the
/// lattice.
struct LostTriangles {
  uint64_t lost = 0, of = 0;  ///< numbers of lost triangles and of all triangles
  double step = 0;            ///< step of the lattice
  glm::dvec3 min{0}, max{0};  ///< box of the model

  /// Returns true if more than half of the triangles are lost. A build then fails.
  bool areMost() const noexcept;
  /// Returns a message with the number of lost triangles, the reason and the remedy.
  std::string inWords() const;
};

/// Counts the triangles that faces lose on a lattice. Cuts polygons as a build does.
class LostTriangleCounter {
 public:
  explicit LostTriangleCounter(const Lattice& lattice) : lattice_(lattice) {}

  /// Counts the lost triangles of one face. @param corners  at least 3 positions, in model units.
  uint64_t count(std::span<const glm::dvec3> corners);

 private:
  bool isLost(std::span<const glm::dvec3> corners, glm::u32vec3 triangle) const;
  bool someMeet();

  const Lattice lattice_;
  std::vector<PositionCode> snapped_, sorted_;  ///< codes of the current face's corners, in order and sorted
  std::vector<glm::dvec3> outline_;
  std::vector<glm::u32vec3> cut_;
};

}  // namespace lode::ingest
