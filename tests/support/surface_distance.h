#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "common/mesh.h"

namespace lode::test {

/// The three corners of a triangle, in any frame.
struct Triangle3 {
  glm::dvec3 a, b, c;
};
using TriangleSoup = std::vector<Triangle3>;

/// Statistics of the distances from sampled points to a surface, in the units of the input.
struct SampledDistance {
  double rms = 0;
  double max = 0;
};

/// Distances between two surfaces, in each direction and in total.
struct SurfaceDistance {
  SampledDistance forward;   ///< from points of the first surface to the second surface
  SampledDistance backward;  ///< from points of the second surface to the first surface
  /// Both directions together: root mean square over all samples (equally many per direction), and the larger
  /// maximum.
  SampledDistance both;
};

/// Finds distances from a surface, by a bounding volume hierarchy over its triangles. Thread safe after
/// construction.
class DistanceField {
 public:
  explicit DistanceField(std::span<const Triangle3> soup);
  ~DistanceField();
  DistanceField(DistanceField&&) noexcept;
  DistanceField& operator=(DistanceField&&) noexcept;

  /// Returns the distance to the nearest point of the surface; infinity for a surface without triangles.
  double distance(glm::dvec3 point) const {
    uint32_t hint = 0;
    return distance(point, hint);
  }
  /// @param hint  number of a triangle that may be near, for example from the last call; receives the number
  /// of the nearest triangle.
  double distance(glm::dvec3 point, uint32_t& hint) const;
  /// Returns the triangle with a number from distance(). These numbers differ from the indices of the input.
  const Triangle3& triangle(uint32_t number) const { return triangles_[number]; }

 private:
  struct Node;
  void build(uint32_t node, uint32_t begin, uint32_t end);
  double squaredDistanceTo(glm::dvec3 point, uint32_t triangle) const;

  std::vector<Triangle3> triangles_;
  std::vector<Node> nodes_;
};

/// Returns points that are spread evenly by area over a surface. The points depend only on the input and the
/// seed. Corners of triangles are not among them, and triangles without area have none.
std::vector<glm::dvec3> samplePoints(std::span<const Triangle3> soup, size_t count, uint64_t seed);

/// Returns the sampled distance between two surfaces, with `samples` points in each direction.
SurfaceDistance surfaceDistance(std::span<const Triangle3> first, std::span<const Triangle3> second,
                                size_t samples = 200000, uint64_t seed = 1);

/// Returns the length of the diagonal of the triangles' box.
double boxDiagonal(std::span<const Triangle3> soup);

/// Returns the triangles of a mesh, in lattice steps.
TriangleSoup latticeSoup(const Mesh& mesh);

}  // namespace lode::test
