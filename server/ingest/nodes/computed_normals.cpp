#include "server/ingest/nodes/computed_normals.h"

#include <vector>

#include "common/octahedral.h"

namespace lode::ingest {

namespace {

constexpr float kShortest = 1e-3f;    ///< of a sum of normals
constexpr float kLeastShare = 1e-3f;  ///< of a corner, in all places together

/// A normal a position; wedges of one position share it.
std::vector<uint16_t> normalsOf(const NodeMesh& mesh) {
  std::vector<uint16_t> normals(mesh.positions.size());
  for (size_t wedge = 0; wedge < mesh.wedge_position.size(); ++wedge)
    normals[mesh.wedge_position[wedge]] = mesh.wedge_attributes[wedge].normal;
  return normals;
}

std::vector<glm::vec3> decoded(std::span<const uint16_t> codes) {
  std::vector<glm::vec3> normals;
  normals.reserve(codes.size());
  for (const uint16_t code : codes) normals.push_back(decodeOctahedral(code));
  return normals;
}

/// Of each position of the rung, the mean of those that have become it; else that of its source.
std::vector<glm::vec3> meansOfMerged(const SimplifiedMesh& rung, std::span<const glm::vec3> normals,
                                     std::span<const uint32_t> sources) {
  std::vector<glm::vec3> means(sources.size(), glm::vec3(0));
  for (size_t i = 0; i < normals.size(); ++i)
    if (rung.became[i] != kVanished) means[rung.became[i]] += normals[i];
  for (size_t i = 0; i < means.size(); ++i)
    means[i] = glm::length(means[i]) > kShortest ? glm::normalize(means[i]) : normals[sources[i]];
  return means;
}

/// Moves a rung's normals towards those with which its triangles, between their corners, come nearest to the
/// normals that are given where the input's positions lie on them: one step of Jacobi's method for these
/// least squares, with the sums of rows in place of the diagonal. Means alone are smoothed twice, when they
/// are taken and when they are interpolated; further steps gain nothing.
std::vector<glm::vec3> sharpened(const SimplifiedMesh& rung, std::span<const glm::vec3> means,
                                 std::span<const glm::vec3> given,
                                 std::span<const SurfaceWalk::Place> places) {
  std::vector<glm::vec4> sums(means.size(), glm::vec4(0));  // of what is missing, and of shares
  for (size_t i = 0; i < given.size(); ++i) {
    if (rung.became[i] == kVanished) continue;
    const glm::u32vec3& t = rung.mesh.triangles[places[i].triangle];
    glm::vec3 here(0);
    for (int k = 0; k < 3; ++k) here += places[i].shares[k] * means[rung.mesh.wedge_position[t[k]]];
    for (int k = 0; k < 3; ++k)
      sums[rung.mesh.wedge_position[t[k]]] += places[i].shares[k] * glm::vec4(given[i] - here, 1);
  }
  std::vector<glm::vec3> normals(means.begin(), means.end());
  for (size_t i = 0; i < normals.size(); ++i)
    if (sums[i].w > kLeastShare) normals[i] += glm::vec3(sums[i]) / sums[i].w;
  return normals;
}

}  // namespace

NodeMesh withoutComputedNormals(NodeMesh mesh) {
  if (!mesh.attributes.has(AttributeSet::kComputedNormal)) return mesh;
  mesh.attributes.bits &= static_cast<uint8_t>(~(AttributeSet::kNormal | AttributeSet::kComputedNormal));
  if (mesh.attributes.bits == 0) mesh.wedge_attributes.clear();
  for (VertexAttributes& attributes : mesh.wedge_attributes) attributes.normal = 0;
  return mesh;
}

void giveComputedNormals(SimplifiedMesh& rung, const NodeMesh& mesh, std::span<const uint32_t> sources,
                         std::span<const SurfaceWalk::Place> places) {
  if (!mesh.attributes.has(AttributeSet::kComputedNormal)) return;
  const std::vector<uint16_t> given = normalsOf(mesh);
  const std::vector<glm::vec3> input = decoded(given), means = meansOfMerged(rung, input, sources);
  const std::vector<glm::vec3> normals = sharpened(rung, means, input, places);
  std::vector<uint16_t> codes(sources.size());
  for (size_t i = 0; i < codes.size(); ++i) {
    const bool is_shared = rung.mesh.lca_depth[i] != kNeverLocked;
    const bool stays = rung.mesh.positions[i] == mesh.positions[sources[i]];
    codes[i] = is_shared && stays
                   ? given[sources[i]]
                   : encodeOctahedral(glm::length(normals[i]) > kShortest ? normals[i] : means[i]);
  }
  rung.mesh.attributes = mesh.attributes;
  rung.mesh.wedge_attributes.resize(rung.mesh.wedge_position.size());
  for (size_t wedge = 0; wedge < rung.mesh.wedge_position.size(); ++wedge)
    rung.mesh.wedge_attributes[wedge].normal = codes[rung.mesh.wedge_position[wedge]];
}

}  // namespace lode::ingest
