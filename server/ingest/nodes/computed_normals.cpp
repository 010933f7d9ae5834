#include "server/ingest/nodes/computed_normals.h"

#include <algorithm>
#include <vector>

#include "common/codec/octahedral.h"
#include "common/codec/surface_normals.h"
#include "common/groups.h"
#include "server/ingest/mesh/mesh_welder.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kNoNormal = ~0u;
constexpr float kShortest = 1e-3f;    ///< smallest usable length of a sum of normals
constexpr float kLeastShare = 1e-3f;  ///< smallest usable sum of the weights for a normal

/// The distinct normals of a mesh, numbered by position. Wedges that differ only in other attributes share a
/// normal. The first normal of a position has the position's number; the numbers of further normals follow
/// after all positions.
struct NormalsByPosition {
  explicit NormalsByPosition(const NodeMesh& mesh)
      : codes(mesh.positions.size()), next(codes.size(), kNoNormal), of_wedge(mesh.wedge_position) {
    std::vector<bool> is_known(codes.size());
    for (size_t wedge = 0; wedge < mesh.wedge_attributes.size(); ++wedge) {
      const uint16_t code = mesh.wedge_attributes[wedge].normal;
      uint32_t& number = of_wedge[wedge];
      if (!is_known[number]) {
        is_known[number] = true;
        codes[number] = code;
      }
      while (codes[number] != code && next[number] != kNoNormal) number = next[number];
      if (codes[number] == code) continue;
      next[number] = static_cast<uint32_t>(codes.size());
      number = next[number];
      codes.push_back(code);
      next.push_back(kNoNormal);
    }
    directions.resize(codes.size(), glm::vec3(0));
    if (!mesh.wedge_attributes.empty())
      std::transform(codes.begin(), codes.end(), directions.begin(), decodeOctahedral);
  }

  bool hasSeveral(uint32_t position) const noexcept { return next[position] != kNoNormal; }
  /// Returns the number of the position's normal that is most similar to a direction.
  uint32_t mostAlike(uint32_t position, glm::vec3 direction) const noexcept {
    uint32_t best = position;
    for (uint32_t i = next[position]; i != kNoNormal; i = next[i])
      if (glm::dot(directions[i], direction) > glm::dot(directions[best], direction)) best = i;
    return best;
  }

  std::vector<uint16_t> codes;
  std::vector<glm::vec3> directions;  ///< zero vectors if the mesh has no normals
  std::vector<uint32_t> next;         ///< next normal of the same position, or kNoNormal
  std::vector<uint32_t> of_wedge;     ///< normal of each wedge
};

bool hasCreases(const NodeMesh& mesh) {
  std::vector<uint32_t> normals(mesh.positions.size(), kNoNormal);
  for (size_t wedge = 0; wedge < mesh.wedge_attributes.size(); ++wedge) {
    uint32_t& normal = normals[mesh.wedge_position[wedge]];
    if (normal == kNoNormal) normal = mesh.wedge_attributes[wedge].normal;
    if (normal != mesh.wedge_attributes[wedge].normal) return true;
  }
  return false;
}

/// Marks the positions of an LOD that keep the input's normals: those that several leaves share and that have
/// not moved.
std::vector<bool> positionsThatKeep(const NodeMesh& lod, const NodeMesh& mesh,
                                    std::span<const uint32_t> sources) {
  std::vector<bool> keep(sources.size());
  for (size_t i = 0; i < keep.size(); ++i)
    keep[i] = lod.lca_depth[i] != kNeverLocked && lod.positions[i] == mesh.positions[sources[i]];
  return keep;
}

/// Merges the normals on both sides of a crease if simplification has flattened the crease below the crease
/// angle. Otherwise creases that are only noise would divide all coarser LODs.
void joinSmoothed(NodeMesh& lod, const std::vector<bool>& keep, const CreaseAngle& crease) {
  const NormalsByPosition own(lod);
  const NormalFans fans = findFans(lod, crease);
  Groups same(own.codes.size());
  std::vector<uint32_t> of_fan(fans.sums.size(), kNoNormal);
  for (size_t c = 0; c < fans.of_corner.size(); ++c) {
    const uint32_t wedge = lod.triangles[c / 3][static_cast<int>(c % 3)];
    if (keep[lod.wedge_position[wedge]]) continue;
    uint32_t& normal = of_fan[fans.of_corner[c]];
    if (normal == kNoNormal) normal = own.of_wedge[wedge];
    same.join(normal, own.of_wedge[wedge]);
  }
  for (size_t wedge = 0; wedge < lod.wedge_attributes.size(); ++wedge)
    lod.wedge_attributes[wedge].normal = own.codes[same.find(own.of_wedge[wedge])];
}

/// Returns one direction per normal of the LOD: the mean of all input normals that map to it, or the normal
/// at the source position if there are none or they cancel out.
std::vector<glm::vec3> meansOfMerged(const SimplifiedMesh& lod, const NormalsByPosition& own,
                                     const NormalsByPosition& given, std::span<const uint32_t> sources) {
  std::vector<glm::vec3> means(own.codes.size(), glm::vec3(0));
  for (uint32_t i = 0; i < lod.remap.size(); ++i) {
    const uint32_t place = lod.remap[i];
    if (place == kVanished) continue;
    for (uint32_t normal = i; normal != kNoNormal; normal = given.next[normal])
      means[own.mostAlike(place, given.directions[normal])] += given.directions[normal];
  }
  for (uint32_t position = 0; position < sources.size(); ++position) {
    for (uint32_t normal = position; normal != kNoNormal; normal = own.next[normal]) {
      const uint32_t nearest = own.hasSeveral(position)
                                   ? given.mostAlike(sources[position], own.directions[normal])
                                   : sources[position];
      means[normal] =
          glm::length(means[normal]) > kShortest ? glm::normalize(means[normal]) : given.directions[nearest];
    }
  }
  return means;
}

/// Moves an LOD's normals, so that their interpolation over the LOD's triangles comes nearer to the normals
/// of the input's positions. Computes one Jacobi step of the least-squares problem, with row sums instead of
/// the diagonal; more steps would gain nothing. Without this step the shading would be smoothed twice, by the
/// mean and by the interpolation.
std::vector<glm::vec3> sharpened(const SimplifiedMesh& lod, const NormalsByPosition& own,
                                 std::span<const glm::vec3> means, const NormalsByPosition& given,
                                 std::span<const SurfaceWalk::Place> places) {
  std::vector<glm::vec4> sums(means.size(), glm::vec4(0));  // sum of residuals (xyz) and of weights (w)
  for (uint32_t i = 0; i < lod.remap.size(); ++i) {
    if (lod.remap[i] == kVanished) continue;
    const glm::u32vec3& t = lod.mesh.triangles[places[i].triangle];
    glm::vec3 here(0);
    for (int k = 0; k < 3; ++k) here += places[i].shares[k] * means[own.of_wedge[t[k]]];
    const glm::vec3 off = given.directions[given.mostAlike(i, here)] - here;
    for (int k = 0; k < 3; ++k) sums[own.of_wedge[t[k]]] += places[i].shares[k] * glm::vec4(off, 1);
  }
  std::vector<glm::vec3> normals(means.begin(), means.end());
  for (size_t i = 0; i < normals.size(); ++i)
    if (sums[i].w > kLeastShare) normals[i] += glm::vec3(sums[i]) / sums[i].w;
  return normals;
}

/// Returns for each normal of the LOD the sum of areaNormal() over the triangle corners that use the normal.
std::vector<glm::i64vec3> sumsOfSurface(const NodeMesh& lod, const NormalsByPosition& own) {
  std::vector<glm::i64vec3> sums(own.codes.size(), glm::i64vec3(0));
  for (const glm::u32vec3& t : lod.triangles) {
    const auto at = [&](int k) { return lod.positions[lod.wedge_position[t[k]]]; };
    const glm::i64vec3 normal = areaNormal(at(0), at(1), at(2));
    for (int k = 0; k < 3; ++k) sums[own.of_wedge[t[k]]] += normal;
  }
  return sums;
}

constexpr uint32_t kNoWedge = ~0u;

std::vector<uint16_t> normalsOfFans(const NodeMesh& mesh, const NormalFans& fans,
                                    std::span<const BorderVertex> border) {
  std::vector<uint16_t> normals;
  normals.reserve(fans.sums.size());
  for (const glm::i64vec3& sum : fans.sums) normals.push_back(normalOf(sum));
  for (size_t p = 0; p < mesh.positions.size() && !border.empty(); ++p) {
    for (const BorderVertex& shared : sharedAt(border, mesh.positions[p]))
      normals[fans.first[p] + shared.fan] = shared.normal;
  }
  return normals;
}

}  // namespace

NodeMesh withoutSmoothNormals(NodeMesh mesh) {
  if (!mesh.attributes.has(AttributeSet::kComputedNormal)) return mesh;
  if (hasCreases(mesh)) return mesh;
  mesh.attributes.bits &= static_cast<uint8_t>(~(AttributeSet::kNormal | AttributeSet::kComputedNormal));
  if (mesh.attributes.bits == 0) mesh.wedge_attributes.clear();
  for (VertexAttributes& attributes : mesh.wedge_attributes) attributes.normal = 0;
  return mesh;
}

void giveComputedNormals(SimplifiedMesh& lod, const NodeMesh& mesh, std::span<const uint32_t> sources,
                         std::span<const SurfaceWalk::Place> places, const CreaseAngle& crease) {
  if (!mesh.attributes.has(AttributeSet::kComputedNormal)) return;
  const std::vector<bool> keep = positionsThatKeep(lod.mesh, mesh, sources);
  const bool has_creases = hasCreases(lod.mesh);
  if (has_creases) joinSmoothed(lod.mesh, keep, crease);
  const NormalsByPosition given(mesh), own(lod.mesh);
  const std::vector<glm::vec3> means = meansOfMerged(lod, own, given, sources);
  const std::vector<glm::vec3> normals = sharpened(lod, own, means, given, places);
  const std::vector<glm::i64vec3> surface = sumsOfSurface(lod.mesh, own);
  std::vector<uint16_t> codes(own.codes.size());
  for (uint32_t position = 0; position < sources.size(); ++position) {
    for (uint32_t normal = position; normal != kNoNormal; normal = own.next[normal]) {
      if (keep[position]) {
        codes[normal] = given.codes[given.mostAlike(sources[position], own.directions[normal])];
      } else {
        const bool is_long = glm::length(normals[normal]) > kShortest;
        codes[normal] =
            cheapNormal(encodeOctahedral(is_long ? normals[normal] : means[normal]), surface[normal]);
      }
    }
  }
  lod.mesh.attributes = mesh.attributes;
  lod.mesh.wedge_attributes.resize(lod.mesh.wedge_position.size());
  for (size_t wedge = 0; wedge < lod.mesh.wedge_position.size(); ++wedge)
    lod.mesh.wedge_attributes[wedge].normal = codes[own.of_wedge[wedge]];
  if (has_creases) joinEqualWedges(lod.mesh);
}

void giveLeafNormals(NodeMesh& mesh, std::span<const BorderVertex> border, const CreaseAngle& crease) {
  const NormalFans fans = findFans(mesh, crease);
  const std::vector<uint16_t> normals = normalsOfFans(mesh, fans, border);
  mesh.wedge_attributes.resize(mesh.wedge_position.size());
  std::vector<char> is_given(mesh.wedge_position.size());
  // Next copy of each wedge, with another normal.
  std::vector<uint32_t> next(mesh.wedge_position.size(), kNoWedge);
  for (size_t c = 0; c < fans.of_corner.size(); ++c) {
    const uint16_t normal = normals[fans.of_corner[c]];
    uint32_t& wedge = mesh.triangles[c / 3][static_cast<int>(c % 3)];
    if (!is_given[wedge]) {
      is_given[wedge] = 1;
      mesh.wedge_attributes[wedge].normal = normal;
      continue;
    }
    while (mesh.wedge_attributes[wedge].normal != normal && next[wedge] != kNoWedge) wedge = next[wedge];
    if (mesh.wedge_attributes[wedge].normal == normal) continue;
    const auto added = static_cast<uint32_t>(mesh.wedge_position.size());
    VertexAttributes attributes = mesh.wedge_attributes[wedge];
    attributes.normal = normal;
    mesh.wedge_attributes.push_back(attributes);
    mesh.wedge_position.push_back(mesh.wedge_position[wedge]);
    next.push_back(kNoWedge);
    next[wedge] = added;
    wedge = added;
  }
}

}  // namespace lode::ingest
