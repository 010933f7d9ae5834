#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/simplify/collapse_mesh.h"

namespace lode::ingest {

/// Lattice places that are or have been taken, as bits under a hash: never forgets one, and takes about one
/// in thirty free ones for taken.
class TakenPlaces {
 public:
  /// @param positions  how many places there are at the beginning; about as many may follow
  explicit TakenPlaces(size_t positions) {
    size_t bits = 1u << 12;
    while (bits < 32 * positions) bits *= 2;
    words_.resize(bits / 64);
  }

  bool contains(glm::dvec3 place) const noexcept {
    const size_t h = hash(place);
    return words_[h / 64] >> h % 64 & 1;
  }
  void add(glm::dvec3 place) noexcept {
    const size_t h = hash(place);
    words_[h / 64] |= uint64_t{1} << h % 64;
  }

 private:
  size_t hash(glm::dvec3 place) const noexcept {
    const auto part = [](double x, uint64_t factor) {
      return static_cast<uint64_t>(static_cast<int64_t>(x)) * factor;
    };
    uint64_t h = part(place.x, 0x9E3779B97F4A7C15u) ^ part(place.y, 0xC2B2AE3D27D4EB4Fu) ^
                 part(place.z, 0x165667B19E3779F9u);
    h ^= h >> 32;
    h *= 0xD6E8FEB86659FD93u;
    h ^= h >> 32;
    return h & (64 * words_.size() - 1);
  }

  std::vector<uint64_t> words_;
};

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
