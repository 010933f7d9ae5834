#pragma once

#include <cstddef>

#include <glm/glm.hpp>

#include "server/ingest/simplify/collapse_mesh.h"
#include "server/ingest/simplify/taken_places.h"

namespace lode::ingest {

/// Chooses places on the lattice for what a collapse moves: on a coarser one where the surface does not
/// suffer, since multiples of a power of two take fewer bytes in a payload.
class LatticePlaces {
 public:
  /// @param mesh  as it is at first. @param highest  corner of the model's box, lattice steps.
  LatticePlaces(const CollapseMesh& mesh, glm::dvec3 highest);

  /// From now on edges get longer until so many triangles are left.
  void aimFor(size_t triangles);

  /// The best by the quadric of the eight points around a place, of those inside the box that are no other
  /// position's; the better end where all are taken. (Rounding to the nearest would add the lattice's noise
  /// to the surface; of eight points one is usually close to it.)
  /// @param off  mean distance of the surface from the place, steps.
  glm::dvec3 settle(glm::dvec3 point, const Quadric& q, double off, glm::dvec3 at_u, glm::dvec3 at_v) const;
  void take(glm::dvec3 place) { taken_.add(place); }

 private:
  glm::dvec3 lowest_, highest_;  ///< of places, relative to the mesh's origin
  double area_ = 0;              ///< of the mesh at first, square steps
  double coarsest_ = 1;          ///< distance of points that edges pay for
  TakenPlaces taken_;
};

}  // namespace lode::ingest
