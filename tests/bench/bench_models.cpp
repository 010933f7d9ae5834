#include "tests/bench/bench_models.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "common/codec/octahedral.h"
#include "server/ingest/mesh/mesh_welder.h"
#include "server/ingest/ply/ply_reader.h"
#include "server/ingest/soup/lattice_choice.h"
#include "server/ingest/soup/triangulate.h"
#include "server/ingest/soup/uv_grid.h"

namespace lode::bench {
namespace {

using ingest::PlyFaces;
using ingest::PlyVertex;

/// Vertices, and triangles as numbers of vertices and of corners in the order of the file.
struct FileContents {
  AttributeSet attributes;
  bool corner_texture = false;
  std::vector<PlyVertex> vertices;
  std::vector<glm::u32vec3> triangles;
  std::vector<glm::u32vec3> corners;  ///< places in `texture`; empty where the file has no such coordinates
  std::vector<glm::vec2> texture;
  std::vector<uint16_t> materials;  ///< a triangle's
};

void addFaces(FileContents& contents, const PlyFaces& faces) {
  std::vector<glm::dvec3> outline;
  std::vector<glm::u32vec3> cut;
  size_t first = 0;
  const auto before = static_cast<uint32_t>(contents.texture.size());
  contents.texture.insert(contents.texture.end(), faces.texture.begin(), faces.texture.end());
  for (size_t face = 0; face < faces.corner_counts.size(); ++face) {
    outline.clear();
    for (uint32_t c = 0; c < faces.corner_counts[face]; ++c)
      outline.push_back(contents.vertices[faces.corners[first + c]].position);
    ingest::triangulate(outline, cut);
    for (const glm::u32vec3 t : cut) {
      const auto vertex = [&](uint32_t c) { return static_cast<uint32_t>(faces.corners[first + c]); };
      contents.triangles.emplace_back(vertex(t.x), vertex(t.y), vertex(t.z));
      if (!faces.texture.empty()) contents.corners.push_back(t + before + static_cast<uint32_t>(first));
      if (!faces.materials.empty()) contents.materials.push_back(faces.materials[face]);
    }
    first += faces.corner_counts[face];
  }
}

FileContents readContents(const char* path) {
  ingest::PlyReader reader(path, {});
  FileContents contents;
  contents.attributes = reader.attributes();
  contents.corner_texture = reader.hasCornerTexture();
  reader.read(
      [&](uint64_t, std::span<const PlyVertex> vertices) {
        contents.vertices.insert(contents.vertices.end(), vertices.begin(), vertices.end());
      },
      [&](const PlyFaces& faces) { addFaces(contents, faces); });
  return contents;
}

/// As a build chooses it, but from all edges.
void chooseLattice(const FileContents& contents, FileNode& node) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  glm::dvec3 min(kInfinity), max(-kInfinity);
  std::vector<double> edges;
  for (const glm::u32vec3 t : contents.triangles) {
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 p = contents.vertices[t[k]].position;
      min = glm::min(min, p);
      max = glm::max(max, p);
      edges.push_back(glm::distance(p, contents.vertices[t[(k + 1) % 3]].position));
    }
  }
  node.lattice.step = ingest::chooseStep(edges, min, max);
  node.lattice.origin = glm::floor(min / node.lattice.step) * node.lattice.step;
  node.extent = node.lattice.snap(max);
}

ingest::UvGrid chooseTextureGrid(const FileContents& contents, const char* path) {
  ingest::UvRange range;
  for (const glm::vec2 uv : contents.texture) range.add(uv);
  if (!contents.corner_texture)
    for (const glm::u32vec3 t : contents.triangles)
      for (int k = 0; k < 3; ++k) range.add(contents.vertices[t[k]].texture);
  return range.empty() ? ingest::UvGrid{} : ingest::chooseUvGrid(range, path);
}

}  // namespace

test::TriangleSoup FileSurface::soup() const {
  test::TriangleSoup result;
  result.reserve(triangles.size());
  for (const glm::u32vec3 t : triangles) result.push_back({points[t.x], points[t.y], points[t.z]});
  return result;
}

FileSurface readSurface(const char* path) {
  FileContents contents = readContents(path);
  FileSurface surface;
  surface.points.reserve(contents.vertices.size());
  for (const PlyVertex& vertex : contents.vertices) surface.points.push_back(vertex.position);
  surface.triangles = std::move(contents.triangles);
  return surface;
}

FileNode readNode(const char* path) {
  const FileContents contents = readContents(path);
  FileNode node;
  chooseLattice(contents, node);
  const ingest::UvGrid grid = chooseTextureGrid(contents, path);
  node.texture_scale = std::exp2(grid.scale_exponent);
  const AttributeSet has = contents.attributes;
  ingest::MeshWelder welder;
  welder.begin(has, contents.vertices.size(), contents.triangles.size());
  for (size_t i = 0; i < contents.triangles.size(); ++i) {
    glm::u32vec3 wedges;
    for (int k = 0; k < 3; ++k) {
      const PlyVertex& vertex = contents.vertices[contents.triangles[i][k]];
      VertexAttributes attributes;
      if (has.has(AttributeSet::kNormal)) attributes.normal = encodeOctahedral(vertex.normal);
      if (has.has(AttributeSet::kColour)) attributes.colour = vertex.colour;
      if (has.has(AttributeSet::kTexture))
        attributes.texture =
            grid.snap(contents.corner_texture ? contents.texture[contents.corners[i][k]] : vertex.texture);
      if (!contents.materials.empty()) attributes.material = contents.materials[i];
      wedges[k] = welder.addCorner(packPosition(node.lattice.snap(vertex.position)), ingest::kNeverLocked,
                                   attributes);
    }
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
