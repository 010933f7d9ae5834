#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "common/lattice.h"

namespace lode::ingest {

/// Of a model's triangles, those that a build drops since the lattice makes corners one that the file has
/// apart.
struct LostTriangles {
  uint64_t lost = 0, of = 0;
  double step = 0;            ///< the lattice's
  glm::dvec3 min{0}, max{0};  ///< box of the model

  /// What is left does not stand for the model: nothing is built of it.
  bool areMost() const noexcept;
  /// How many, why, and what to do.
  std::string inWords() const;
};

/// Counts the triangles that faces lose to a lattice; polygons are cut as a build cuts them.
class LostTriangleCounter {
 public:
  explicit LostTriangleCounter(const Lattice& lattice) : lattice_(lattice) {}

  /// Of one face. @param corners  true coordinates, >= 3.
  uint64_t count(std::span<const glm::dvec3> corners);

 private:
  bool isLost(std::span<const glm::dvec3> corners, glm::u32vec3 triangle) const;
  bool someMeet();

  const Lattice lattice_;
  std::vector<PositionCode> snapped_, sorted_;  ///< of the face at hand, as are the next
  std::vector<glm::dvec3> outline_;
  std::vector<glm::u32vec3> cut_;
};

}  // namespace lode::ingest
