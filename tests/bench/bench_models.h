#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "common/lattice.h"
#include "server/ingest/mesh/node_mesh.h"
#include "tests/support/surface_distance.h"

namespace lode::bench {

/// Positions and triangles of a PLY file, unchanged.
struct FileSurface {
  std::vector<glm::dvec3> points;
  std::vector<glm::u32vec3> triangles;

  test::TriangleSoup soup() const;
};

/// @throws Error as ingest::PlyReader.
FileSurface readSurface(const char* path);

/// A surface as the mesh of one node on its lattice, without attributes and locked vertices.
struct FileNode {
  ingest::NodeMesh mesh;
  Lattice lattice;
  glm::uvec3 extent{0};  ///< largest coordinates
};

FileNode nodeOf(const FileSurface& surface);

/// Triangles of a node's mesh in lattice steps.
test::TriangleSoup latticeSoup(const ingest::NodeMesh& mesh);

/// Measures two-sided distances between surfaces and one original, relative to the diagonal of the original's
/// box. Always samples the same points of the original, and the same number of points of the other surface.
class Original {
 public:
  Original(std::span<const test::Triangle3> soup, size_t samples);
  test::SampledDistance distanceOf(std::span<const test::Triangle3> other) const;

 private:
  double diagonal_;
  size_t samples_;
  std::vector<glm::dvec3> points_;
  test::DistanceField field_;
};

}  // namespace lode::bench
