#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "server/sample/sample.h"
#include "tests/support/bytes.h"
#include "tests/unit/ingest/ply/ply_fixture.h"

namespace lode::ingest {

constexpr uint8_t kAllOfASample = AttributeSet::kNormal | AttributeSet::kColour | AttributeSet::kTexture;

inline SampleOptions sampleOf(const std::string& kind, uint64_t triangles, uint8_t attributes = 0,
                              uint64_t seed = 1, unsigned threads = 1) {
  return {kind, triangles, {attributes}, seed, threads};
}

inline std::string sampleBytes(const SampleOptions& options) {
  const PlyFolder folder;
  writeSample(options, folder.path() / "sample.ply");
  return test::readBytes(folder.path() / "sample.ply");
}

inline PlyContent sampleContent(const SampleOptions& options) { return readPlyBytes(sampleBytes(options)); }

using DirectedEdge = std::pair<uint64_t, uint64_t>;

/// Counts uses of each directed edge: a mesh is closed and consistently wound if each has its opposite.
inline std::map<DirectedEdge, int> directedEdges(const PlyContent& content) {
  std::map<DirectedEdge, int> edges;
  for (const auto& face : content.faces) {
    for (size_t i = 0; i < 3; ++i) ++edges[{face[i], face[(i + 1) % 3]}];
  }
  return edges;
}

/// Returns the normal with length of twice the area.
inline glm::dvec3 faceNormal(const PlyContent& content, size_t face) {
  const auto corner = [&](size_t i) { return content.vertices[content.faces[face][i]].position; };
  return glm::cross(corner(1) - corner(0), corner(2) - corner(0));
}

/// Returns the mean cosine between vertex normals and normals of their faces.
inline double agreementOfNormals(const PlyContent& content) {
  std::vector<glm::dvec3> sums(content.vertices.size());
  for (size_t i = 0; i < content.faces.size(); ++i) {
    for (const uint64_t corner : content.faces[i]) sums[corner] += faceNormal(content, i);
  }
  double cosines = 0;
  for (size_t i = 0; i < sums.size(); ++i) {
    cosines += glm::dot(glm::normalize(sums[i]), glm::dvec3(content.vertices[i].normal));
  }
  return cosines / static_cast<double>(sums.size());
}

/// Counts the pieces that are connected by edges.
inline size_t piecesOf(const PlyContent& content) {
  std::vector<size_t> parent(content.vertices.size());
  for (size_t i = 0; i < parent.size(); ++i) parent[i] = i;
  const auto root = [&](size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& face : content.faces) {
    parent[root(face[1])] = root(face[0]);
    parent[root(face[2])] = root(face[0]);
  }
  size_t pieces = 0;
  for (size_t i = 0; i < parent.size(); ++i) pieces += parent[i] == i ? 1 : 0;
  return pieces;
}

}  // namespace lode::ingest
