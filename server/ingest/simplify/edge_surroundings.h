#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/mesh/four_vectors.h"
#include "server/ingest/simplify/collapse_mesh.h"

namespace lode::ingest {

/// The triangles around the ends u and v of an edge, fetched once for all that look at its collapse: first
/// those of u alone, then those of v alone; of those of both the third corners.
class EdgeSurroundings {
 public:
  /// The corners of a triangle that follow the end of the edge.
  struct Side {
    uint32_t a, b;
  };
  /// Where the sides of four triangles lie; in the last four the last triangle fills the places of those
  /// that are missing.
  struct FourSides {
    FourVectors a, b;
  };

  explicit EdgeSurroundings(const CollapseMesh& mesh) : mesh_(mesh) {}

  void gather(uint32_t u, uint32_t v);

  uint32_t u() const noexcept { return u_; }
  uint32_t v() const noexcept { return v_; }
  std::span<const Side> ofU() const noexcept { return {sides_.data(), of_u_}; }
  std::span<const Side> ofV() const noexcept { return {sides_.data() + of_u_, of_v_}; }
  /// Of the triangles of the edge.
  std::span<const uint32_t> apexes() const noexcept { return {apexes_.data(), of_both_}; }
  /// Of u, then of v.
  std::span<const FourSides> places() const noexcept { return {places_.data(), (of_u_ + of_v_ + 3) / 4}; }

 private:
  /// Appends the triangles at an end: those with the other end to the apexes.
  void gatherEnd(uint32_t end, uint32_t other, size_t& sides, size_t& apexes);
  FourVectors four(uint32_t a, uint32_t b, uint32_t c, uint32_t d) const noexcept;

  const CollapseMesh& mesh_;
  uint32_t u_ = 0, v_ = 0;
  size_t of_u_ = 0, of_v_ = 0, of_both_ = 0;
  std::vector<Side> sides_;
  std::vector<uint32_t> apexes_;
  std::vector<FourSides> places_;
};

}  // namespace lode::ingest
