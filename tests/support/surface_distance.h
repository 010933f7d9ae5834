#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "common/mesh.h"

namespace lode::test {

/// Three corners of a triangle, in any one frame.
struct Triangle3 {
  glm::dvec3 a, b, c;
};
using TriangleSoup = std::vector<Triangle3>;

/// Distances of sampled points of one surface from the other, in the units of the soups.
struct SampledDistance {
  double rms = 0;
  double max = 0;
};

/// Both directions, and both together.
struct SurfaceDistance {
  SampledDistance forward;   ///< points of the first surface, to the second
  SampledDistance backward;  ///< points of the second surface, to the first
  /// Two-sided: root of the mean over all samples of both directions (equally many), and the larger maximum.
  SampledDistance both;
};

/// A surface that answers how far points are from it: a bounding volume hierarchy over its triangles.
/// Thread safe after construction.
class DistanceField {
 public:
  explicit DistanceField(std::span<const Triangle3> soup);
  ~DistanceField();
  DistanceField(DistanceField&&) noexcept;
  DistanceField& operator=(DistanceField&&) noexcept;

  /// Distance to the nearest point of the surface; infinite for a surface without triangles.
  double distance(glm::dvec3 point) const {
    uint32_t hint = 0;
    return distance(point, hint);
  }
  /// @param hint  number of a triangle that may be near (from the last answer); receives the nearest one's.
  double distance(glm::dvec3 point, uint32_t& hint) const;
  /// The triangle of a number from distance(); numbers are not the soup's.
  const Triangle3& triangle(uint32_t number) const { return triangles_[number]; }

 private:
  struct Node;
  void build(uint32_t node, uint32_t begin, uint32_t end);
  double squaredDistanceTo(glm::dvec3 point, uint32_t triangle) const;

  std::vector<Triangle3> triangles_;
  std::vector<Node> nodes_;
};

/// Points spread evenly by area over a surface, always the same for the same soup and seed; the corners of
/// triangles are not among them. Triangles without area get none.
std::vector<glm::dvec3> samplePoints(std::span<const Triangle3> soup, size_t count, uint64_t seed);

/// Sampled distance between two surfaces, `samples` points each way.
SurfaceDistance surfaceDistance(std::span<const Triangle3> first, std::span<const Triangle3> second,
                                size_t samples = 200000, uint64_t seed = 1);

/// Length of the diagonal of a soup's box.
double boxDiagonal(std::span<const Triangle3> soup);

/// The triangles of a mesh in steps of its lattice.
TriangleSoup latticeSoup(const Mesh& mesh);

}  // namespace lode::test
