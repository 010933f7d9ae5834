#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "server/ingest/mesh/four_vectors.h"
#include "server/ingest/simplify/collapse_mesh.h"

namespace lode::ingest {

/// The triangles around an edge (u, v), gathered once for all checks of the edge's collapse. Triangles that
/// have u but not v come first, then triangles that have v but not u. For a triangle that has both ends,
/// stores only the third corner, the apex.
class EdgeSurroundings {
 public:
  /// The side of a triangle opposite to an end of the edge: the triangle's two other corners, in their order.
  struct Side {
    uint32_t a, b;
  };
  /// Points at the ends of four sides, one side per SIMD lane. The last group is filled up with copies of the
  /// last side.
  struct FourSides {
    FourVectors a, b;
  };

  explicit EdgeSurroundings(const CollapseMesh& mesh) : mesh_(mesh) {}

  void gather(uint32_t u, uint32_t v);

  uint32_t u() const noexcept { return u_; }
  uint32_t v() const noexcept { return v_; }
  std::span<const Side> ofU() const noexcept { return {sides_.data(), of_u_}; }
  std::span<const Side> ofV() const noexcept { return {sides_.data() + of_u_, of_v_}; }
  /// Returns the third corners of the triangles that have both ends.
  std::span<const uint32_t> apexes() const noexcept { return {apexes_.data(), of_both_}; }
  /// Returns the points of ofU(), then of ofV(), in groups of four.
  std::span<const FourSides> places() const noexcept { return {places_.data(), (of_u_ + of_v_ + 3) / 4}; }

 private:
  /// Appends the triangles at `end` to sides_. If a triangle also has `other`, appends the triangle's third
  /// corner to apexes_ instead.
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
