#include "tests/bench/bench_models.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/ply/ply_reader.h"
#include "server/ingest/soup/lattice_choice.h"
#include "server/ingest/soup/triangulate.h"

namespace lode::bench {
namespace {

using ingest::PlyFaces;
using ingest::PlyVertex;

void addFaces(FileSurface& surface, const PlyFaces& faces) {
  std::vector<glm::dvec3> outline;
  std::vector<glm::u32vec3> cut;
  size_t first = 0;
  for (const uint32_t corner_count : faces.corner_counts) {
    outline.clear();
    for (uint32_t c = 0; c < corner_count; ++c) outline.push_back(surface.points[faces.corners[first + c]]);
    ingest::triangulate(outline, cut);
    for (const glm::u32vec3 t : cut) {
      const auto vertex = [&](uint32_t c) { return static_cast<uint32_t>(faces.corners[first + c]); };
      surface.triangles.emplace_back(vertex(t.x), vertex(t.y), vertex(t.z));
    }
    first += corner_count;
  }
}

/// Chooses the lattice as a build does, but from all edges.
void chooseLattice(const FileSurface& surface, FileNode& node) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  glm::dvec3 min(kInfinity), max(-kInfinity);
  std::vector<double> edges;
  for (const glm::u32vec3 t : surface.triangles) {
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 p = surface.points[t[k]];
      min = glm::min(min, p);
      max = glm::max(max, p);
      edges.push_back(glm::distance(p, surface.points[t[(k + 1) % 3]]));
    }
  }
  node.lattice.step = ingest::chooseStep(edges, min, max);
  node.lattice.origin = glm::floor(min / node.lattice.step) * node.lattice.step;
  node.extent = node.lattice.snap(max);
}

}  // namespace

test::TriangleSoup FileSurface::soup() const {
  test::TriangleSoup result;
  result.reserve(triangles.size());
  for (const glm::u32vec3 t : triangles) result.push_back({points[t.x], points[t.y], points[t.z]});
  return result;
}

FileSurface readSurface(const char* path) {
  ingest::PlyReader reader(path, {});
  FileSurface surface;
  reader.read(
      [&](uint64_t, std::span<const PlyVertex> vertices) {
        for (const PlyVertex& vertex : vertices) surface.points.push_back(vertex.position);
      },
      [&](const PlyFaces& faces) { addFaces(surface, faces); });
  return surface;
}

FileNode nodeOf(const FileSurface& surface) {
  FileNode node;
  chooseLattice(surface, node);
  ingest::MeshWelder welder;
  welder.begin({}, surface.points.size(), surface.triangles.size());
  for (const glm::u32vec3 t : surface.triangles) {
    glm::u32vec3 wedges;
    for (int k = 0; k < 3; ++k)
      wedges[k] = welder.addCorner(packPosition(node.lattice.snap(surface.points[t[k]])),
                                   ingest::kNeverLocked, VertexAttributes{});
    welder.addTriangle(wedges);
  }
  node.mesh = welder.finish();
  return node;
}

test::TriangleSoup latticeSoup(const ingest::NodeMesh& mesh) {
  const auto corner = [&](uint32_t wedge) {
    return glm::dvec3(unpackPosition(mesh.positions[mesh.wedge_position[wedge]]));
  };
  test::TriangleSoup soup;
  soup.reserve(mesh.triangles.size());
  for (const glm::u32vec3 t : mesh.triangles) soup.push_back({corner(t.x), corner(t.y), corner(t.z)});
  return soup;
}

Original::Original(std::span<const test::Triangle3> soup, size_t samples)
    : diagonal_(test::boxDiagonal(soup)),
      samples_(samples),
      points_(test::samplePoints(soup, samples, 1)),
      field_(soup) {}

test::SampledDistance Original::distanceOf(std::span<const test::Triangle3> other) const {
  test::SampledDistance result;
  double squares = 0;
  const auto addWay = [&](std::span<const glm::dvec3> points, const test::DistanceField& field) {
    uint32_t hint = 0;
    double sum = 0;
    for (const glm::dvec3 p : points) {
      const double d = field.distance(p, hint);
      sum += d * d;
      result.max = std::max(result.max, d);
    }
    if (!points.empty()) squares += sum / static_cast<double>(points.size());
  };
  addWay(points_, test::DistanceField(other));
  addWay(test::samplePoints(other, samples_, 2), field_);
  return {std::sqrt(squares / 2) / diagonal_, result.max / diagonal_};
}

}  // namespace lode::bench
