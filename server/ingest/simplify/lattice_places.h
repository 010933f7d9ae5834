#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/simplify/collapse_mesh.h"

namespace lode::ingest {

/// Set of the lattice points that positions occupy or have occupied, as a bitmap of hashes. contains()
/// returns true for every added point, and also for about 1 in 30 other points.
class TakenPlaces {
 public:
  /// @param positions  initial number of points; the error rate holds for up to about twice as many points
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

/// Chooses lattice points for merged positions. Prefers a coarser grid if the surface allows it, because
/// multiples of a power of two compress better.
class LatticePlaces {
 public:
  /// @param mesh  the unsimplified mesh. @param highest  upper corner of the model's box, in lattice steps.
  LatticePlaces(const CollapseMesh& mesh, glm::dvec3 highest);

  /// Adapts the grid to the edge length that the mesh will have at this number of triangles.
  void aimFor(size_t triangles);

  /// Returns the grid point with the smallest quadric error among the eight around `point`, clamped to the
  /// box. Skips points that other positions occupy; if all are occupied, returns the better end of the edge.
  /// The nearest grid point alone may lie off the surface, which would add noise; one of the eight points is
  /// usually near the surface.
  /// @param off  mean distance of the surface from `point`, in lattice steps.
  glm::dvec3 settle(glm::dvec3 point, const Quadric& q, double off, glm::dvec3 at_u, glm::dvec3 at_v) const;
  void take(glm::dvec3 place) { taken_.add(place); }

 private:
  glm::dvec3 lowest_, highest_;  ///< box of allowed points, relative to the mesh's origin
  double area_ = 0;              ///< area of the unsimplified mesh, in square steps
  double coarsest_ = 1;          ///< largest grid spacing that the length of edges allows
  TakenPlaces taken_;
};

}  // namespace lode::ingest
