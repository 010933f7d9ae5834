#include "server/ingest/simplify/collapse_mesh.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include "server/ingest/mesh/node_mesh.h"
#include "server/ingest/mesh/wedge_finder.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kNoIndex = ~0u;
constexpr uint32_t kSlack = 4;  // number of spare slots of a corner list after the list has moved
// If at least this many triangles are removed at once, each affected corner list is scanned once for all of
// them.
constexpr size_t kMany = 64;

// In lists longer than this, the slot of each corner is recorded, so that corners are removed without a
// search.
constexpr uint32_t kLongList = 256;

// Weight of a position's own point in its quadric, relative to the planes of its triangles, which are
// weighted by area. The point makes the optimum unique on flat surfaces.
constexpr double kPointWeight = 1e-6;
// Weight of the plane through a boundary edge, relative to the edge's squared length.
constexpr double kBoundaryWeight = 2;
// Weight of the plane through a seam edge, relative to the edge's squared length.
constexpr double kSeamWeight = 1;

std::array<uint32_t, 3> cornersOf(const CollapseMesh& mesh, uint32_t corner) {
  const uint32_t first = corner & ~3u;
  return {mesh.at(first), mesh.at(first + 1), mesh.at(first + 2)};
}

glm::dvec3 normalOf(const CollapseMesh& mesh, const std::array<uint32_t, 3>& t) {
  return glm::cross(mesh.point(t[1]) - mesh.point(t[0]), mesh.point(t[2]) - mesh.point(t[0]));
}

}  // namespace

CollapseMesh::CollapseMesh(NodeMesh&& mesh, int node_depth)
    : attributes(mesh.attributes),
      points(mesh.positions.size()),
      positions(mesh.positions.size()),
      quadrics(mesh.positions.size()),
      areas(mesh.positions.size()) {
  LatticeBox box;
  for (const PositionCode code : mesh.positions) box.add(unpackPosition(code));
  if (!box.empty()) origin = glm::floor(0.5 * (glm::dvec3(box.min) + glm::dvec3(box.max)));
  for (uint32_t i = 0; i < positions.size(); ++i) {
    CollapsePosition& position = positions[i];
    points[i] = glm::ivec4(glm::ivec3(unpackPosition(mesh.positions[i])) - glm::ivec3(origin), 0);
    position.lca_depth = mesh.lca_depth[i];
    position.locked = mesh.lca_depth[i] < node_depth;
  }
  live_triangles = mesh.triangles.size();
  const bool has_wedges = !mesh.wedge_attributes.empty();
  corner_position.resize(4 * live_triangles);
  if (has_wedges) corner_wedge.resize(4 * live_triangles);
  for (size_t t = 0; t < live_triangles; ++t) {
    for (int k = 0; k < 3; ++k) {
      const uint32_t wedge = mesh.triangles[t][k];
      corner_position[4 * t + k] = mesh.wedge_position[wedge];
      if (has_wedges) corner_wedge[4 * t + k] = wedge;
    }
  }
  wedges = WedgeTable(attributes, std::move(mesh.wedge_attributes));
  mesh = {};  // free the input's memory before simplification
  gatherCorners();
  if (has_wedges) {
    only_wedge.resize(positions.size());
    for (uint32_t i = 0; i < positions.size(); ++i) only_wedge[i] = findOnlyWedge(i);
  }
}

void CollapseMesh::gatherCorners() {
  const uint32_t corners = static_cast<uint32_t>(4 * live_triangles);
  for (uint32_t c = 0; c < corners; c += 4) {
    for (uint32_t k = 0; k < 3; ++k) ++positions[corner_position[c + k]].capacity;
  }
  uint32_t first = 0;
  for (CollapsePosition& position : positions) {
    position.first = first;
    first += position.capacity;
  }
  pool.reserve(3 * static_cast<size_t>(first));
  pool.resize(first);
  for (uint32_t c = 0; c < corners; c += 4) {
    for (uint32_t k = 0; k < 3; ++k) {
      CollapsePosition& position = positions[corner_position[c + k]];
      pool[position.first + position.count++] = c + k;
    }
  }
  for (const CollapsePosition& position : positions) noteSlots(position, 0);
}

void CollapseMesh::noteSlots(const CollapsePosition& list, uint32_t from) {
  if (list.count <= kLongList) return;
  if (slots_.empty()) slots_.resize(corner_position.size());
  for (uint32_t i = list.first + from; i < list.first + list.count; ++i) slots_[pool[i]] = i;
}

void CollapseMesh::findEdges(uint32_t u, std::vector<Edge>& edges, std::vector<uint32_t>& places) const {
  edges.clear();
  for (const uint32_t corner : around(u)) {
    for (const uint32_t other : {next(corner), previous(corner)}) {
      const uint32_t v = corner_position[other];
      if (v < u) continue;
      const uint32_t wedge_u = hasWedges() ? corner_wedge[corner] : 0;
      const uint32_t wedge_v = hasWedges() ? corner_wedge[other] : 0;
      if (places[v] < edges.size() && edges[places[v]].v == v) {
        Edge& edge = edges[places[v]];
        ++edge.uses;
        edge.seam |= edge.wedge_u != wedge_u || edge.wedge_v != wedge_v;
      } else {
        places[v] = static_cast<uint32_t>(edges.size());
        edges.push_back({u, v, 1, corner, wedge_u, wedge_v, false});
      }
    }
  }
}

EdgeKind CollapseMesh::edgeKind(uint32_t u, uint32_t v) const noexcept {
  if (positions[v].count < positions[u].count) std::swap(u, v);
  uint32_t uses = 0, wedge_u = 0, wedge_v = 0;
  bool seam = false;
  for (const uint32_t corner : around(u)) {
    for (const uint32_t other : {next(corner), previous(corner)}) {
      if (corner_position[other] != v) continue;
      if (hasWedges()) {
        seam |= uses > 0 && (wedge_u != corner_wedge[corner] || wedge_v != corner_wedge[other]);
        wedge_u = corner_wedge[corner];
        wedge_v = corner_wedge[other];
      }
      ++uses;
    }
  }
  if (uses == 0) return EdgeKind::kSmooth;
  return uses != 2 ? EdgeKind::kBoundary : seam ? EdgeKind::kSeam : EdgeKind::kSmooth;
}

void CollapseMesh::classify(const std::vector<Features>& features) {
  for (size_t i = 0; i < positions.size(); ++i) {
    const auto [seams, boundaries] = features[i];
    positions[i].kind = boundaries == 0                 ? seams == 0   ? PositionKind::kSmooth
                                                          : seams == 2 ? PositionKind::kSeam
                                                                       : PositionKind::kSeamCorner
                        : boundaries == 2 && seams == 0 ? PositionKind::kBoundary
                                                        : PositionKind::kBoundaryCorner;
  }
}

void CollapseMesh::unlist(uint32_t corner) {
  CollapsePosition& list = positions[corner_position[corner]];
  uint32_t* const begin = pool.data() + list.first;
  const uint32_t last = begin[--list.count];
  if (list.count < kLongList) {
    *std::find(begin, begin + list.count, corner) = last;
  } else {
    pool[slots_[corner]] = last;
    slots_[last] = slots_[corner];
  }
}

void CollapseMesh::kill(uint32_t corner, bool is_listed) {
  if (is_listed) unlist(corner);
  for (const uint32_t other : {next(corner), previous(corner)}) {
    unlist(other);
    corner_position[other] = kNoIndex;
  }
  corner_position[corner] = kNoIndex;
  --live_triangles;
}

void CollapseMesh::killAll(std::span<const uint32_t> corners, bool are_listed) {
  if (corners.size() < kMany) {
    for (const uint32_t corner : corners) kill(corner, are_listed);
    return;
  }
  std::vector<uint32_t> touched;
  for (const uint32_t corner : corners) {
    for (uint32_t c = corner / 4 * 4; c < corner / 4 * 4 + 3; ++c) {
      if (are_listed || c != corner) touched.push_back(corner_position[c]);
      corner_position[c] = kNoIndex;
    }
  }
  live_triangles -= corners.size();
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  for (const uint32_t position : touched) {
    CollapsePosition& list = positions[position];
    uint32_t* const begin = pool.data() + list.first;
    uint32_t* const end = std::remove_if(
        begin, begin + list.count, [&](uint32_t corner) { return corner_position[corner] == kNoIndex; });
    list.count = static_cast<uint32_t>(end - begin);
    noteSlots(list, 0);
  }
}

void CollapseMesh::merge(uint32_t keep, uint32_t gone, glm::dvec3 point, double gone_share) {
  if (hasWedges()) mergeWedges(keep, gone, gone_share);
  CollapsePosition& kept = positions[keep];
  CollapsePosition& left = positions[gone];
  dying_.assign(around(gone).begin(), around(gone).end());
  const auto shared = std::partition(dying_.begin(), dying_.end(), [&](uint32_t corner) {
    return corner_position[next(corner)] != keep && corner_position[previous(corner)] != keep;
  });
  killAll(std::span(shared, dying_.end()), false);
  const uint32_t moving = static_cast<uint32_t>(shared - dying_.begin());
  const bool moves = kept.count + moving > kept.capacity, was_long = kept.count > kLongList;
  if (moves) {
    const uint32_t total = kept.count + moving;
    if (total <= left.capacity) {
      std::copy_n(pool.data() + kept.first, kept.count, pool.data() + left.first);
      kept.first = left.first;
      kept.capacity = left.capacity;
    } else {
      const uint32_t capacity = total + kSlack + total / 8, first = static_cast<uint32_t>(pool.size());
      pool.resize(first + capacity);
      std::copy_n(pool.data() + kept.first, kept.count, pool.data() + first);
      kept.first = first;
      kept.capacity = capacity;
    }
  }
  const uint32_t before = kept.count;
  for (uint32_t i = 0; i < moving; ++i) {
    pool[kept.first + kept.count++] = dying_[i];
    corner_position[dying_[i]] = keep;
  }
  noteSlots(kept, was_long && !moves ? before : 0);
  left.count = left.capacity = 0;
  points[keep] = glm::ivec4(point, 0);
  quadrics[keep] += quadrics[gone];
  areas[keep] += areas[gone];
  if (hasWedges() && (only_wedge[keep] == kManyWedges || only_wedge[gone] == kManyWedges))
    only_wedge[keep] = findOnlyWedge(keep);
}

uint32_t CollapseMesh::findOnlyWedge(uint32_t position) const noexcept {
  uint32_t wedge = kManyWedges;
  for (const uint32_t corner : around(position)) {
    if (wedge != kManyWedges && wedge != corner_wedge[corner]) return kManyWedges;
    wedge = corner_wedge[corner];
  }
  return wedge;
}

void CollapseMesh::findPairs(uint32_t keep, uint32_t gone, std::vector<WedgeTable::Pair>& pairs) {
  pairs.clear();
  const uint64_t stamp = newStamp();
  for (const uint32_t corner : around(gone)) {
    for (const uint32_t other : {next(corner), previous(corner)}) {
      if (corner_position[other] != keep) continue;
      const uint32_t wedge = corner_wedge[corner];
      if (std::exchange(wedge_marks_[wedge], stamp) == stamp) continue;
      pairs.push_back({corner_wedge[other], wedge});
    }
  }
}

// Returns true if some triangle has both positions as corners.
bool CollapseMesh::share(uint32_t keep, uint32_t gone) const noexcept {
  return std::ranges::any_of(around(gone), [&](uint32_t corner) {
    return corner_position[next(corner)] == keep || corner_position[previous(corner)] == keep;
  });
}

// Merges a wedge of `gone` into a wedge of `keep` if one triangle of the collapsing edge has both. Other
// wedges of `gone` remain separate. Wedges of a locked position never merge with each other.
void CollapseMesh::mergeWedges(uint32_t keep, uint32_t gone, double gone_share) {
  const uint32_t wedge_keep = only_wedge[keep], wedge_gone = only_wedge[gone];
  if (wedge_keep != kManyWedges && wedge_gone != kManyWedges && share(keep, gone)) {
    pairs_.assign(1, {wedge_keep, wedge_gone});
    if (mixes_values) wedges.mix(wedge_keep, wedge_gone, gone_share);
    for (const uint32_t corner : around(gone)) corner_wedge[corner] = wedge_keep;
    return;
  }
  findPairs(keep, gone, pairs_);
  const uint64_t stamp = newStamp();
  for (const WedgeTable::Pair& pair : pairs_) {
    const bool again = std::exchange(wedge_marks_[pair.keep], stamp) == stamp;
    if (!again && mixes_values) wedges.mix(pair.keep, pair.gone, gone_share);
  }
  const uint64_t first = stamp + 1;  // the wedge pairs_[i].gone is marked first + i
  for (const WedgeTable::Pair& pair : pairs_) wedge_marks_[pair.gone] = newStamp();
  for (const uint32_t corner : around(gone)) {
    const uint64_t mark = wedge_marks_[corner_wedge[corner]];
    if (mark >= first) corner_wedge[corner] = pairs_[mark - first].keep;
  }
}

void CollapseMesh::removeFolds(uint32_t position) {
  // A triangle at `position`: the smaller and the larger index of its other positions, whether the triangle
  // lists the smaller one first, and the corner at `position`.
  using Side = std::tuple<uint32_t, uint32_t, bool, uint32_t>;
  std::vector<Side> sides;
  for (const uint32_t corner : around(position)) {
    const uint32_t a = corner_position[next(corner)], b = corner_position[previous(corner)];
    sides.emplace_back(std::min(a, b), std::max(a, b), a < b, corner);
  }
  std::sort(sides.begin(), sides.end());
  dying_.clear();
  for (size_t begin = 0, end; begin < sides.size(); begin = end) {
    const auto same = [&](const Side& side) {
      return std::get<0>(side) == std::get<0>(sides[begin]) && std::get<1>(side) == std::get<1>(sides[begin]);
    };
    for (end = begin; end < sides.size() && same(sides[end]);) ++end;
    size_t backward = begin;
    while (backward < end && !std::get<2>(sides[backward])) ++backward;
    const size_t pairs = std::min(backward - begin, end - backward);
    for (size_t i = 0; i < pairs; ++i) {
      dying_.push_back(std::get<3>(sides[begin + i]));
      dying_.push_back(std::get<3>(sides[backward + i]));
    }
  }
  killAll(dying_, true);
}

NodeMesh CollapseMesh::compact(std::vector<uint32_t>& new_position) const {
  NodeMesh result;
  result.attributes = attributes;
  new_position.assign(positions.size(), kVanished);
  for (uint32_t i = 0; i < positions.size(); ++i) {
    if (positions[i].count == 0) continue;
    new_position[i] = static_cast<uint32_t>(result.positions.size());
    result.positions.push_back(packPosition(glm::uvec3(point(i) + origin)));
    result.lca_depth.push_back(positions[i].lca_depth);
  }
  result.triangles.reserve(live_triangles);
  if (!hasWedges()) {
    result.wedge_position.resize(result.positions.size());
    for (size_t i = 0; i < result.positions.size(); ++i) result.wedge_position[i] = static_cast<uint32_t>(i);
    for (size_t c = 0; c < corner_position.size(); c += 4) {
      if (corner_position[c] == kNoIndex) continue;
      result.triangles.emplace_back(new_position[corner_position[c]], new_position[corner_position[c + 1]],
                                    new_position[corner_position[c + 2]]);
    }
    return result;
  }
  // Merge the wedges of a position if their attributes have become equal.
  std::vector<uint32_t> new_wedge(wedges.size(), kNoIndex);
  WedgeFinder known;
  for (uint32_t i = 0; i < positions.size(); ++i) {
    known.reset(1);
    for (const uint32_t corner : around(i)) {
      uint32_t& wedge = new_wedge[corner_wedge[corner]];
      if (wedge != kNoIndex) continue;
      const VertexAttributes code = wedges.code(corner_wedge[corner]);
      wedge = known.find(0, code, result.wedge_attributes);
      if (wedge != WedgeFinder::kNone) continue;
      wedge = static_cast<uint32_t>(result.wedge_position.size());
      result.wedge_position.push_back(new_position[i]);
      result.wedge_attributes.push_back(code);
      known.add(0, wedge, result.wedge_attributes);
    }
  }
  for (size_t c = 0; c < corner_position.size(); c += 4) {
    if (corner_position[c] == kNoIndex) continue;
    result.triangles.emplace_back(new_wedge[corner_wedge[c]], new_wedge[corner_wedge[c + 1]],
                                  new_wedge[corner_wedge[c + 2]]);
  }
  return result;
}

void addPlanes(CollapseMesh& mesh) {
  std::vector<double> areas(mesh.positions.size());
  for (uint32_t c = 0; c < mesh.corner_position.size(); c += 4) {
    const std::array<uint32_t, 3> t = cornersOf(mesh, c);
    const glm::dvec3 normal = normalOf(mesh, t);
    const double length = glm::length(normal);
    if (length == 0) continue;
    Quadric plane;
    // The length of `normal` is twice the area. The weight makes the term equal to that of the unit normal,
    // weighted by the area.
    plane.addPlane(normal, -glm::dot(normal, mesh.point(t[0])), 0.5 / length);
    for (const uint32_t i : t) {
      mesh.quadrics[i] += plane;
      areas[i] += 0.5 * length;
    }
  }
  for (uint32_t i = 0; i < areas.size(); ++i) {
    mesh.quadrics[i].addPoint(mesh.point(i), kPointWeight * areas[i]);
    mesh.areas[i] = static_cast<float>(areas[i]);
  }
}

void addFeature(CollapseMesh& mesh, const CollapseMesh::Edge& edge) {
  const EdgeKind kind = edge.kind();
  if (kind == EdgeKind::kSmooth) return;
  if (mesh.positions[edge.u].locked && mesh.positions[edge.v].locked) return;
  const glm::dvec3 along = mesh.point(edge.v) - mesh.point(edge.u);
  const glm::dvec3 across = glm::cross(along, normalOf(mesh, cornersOf(mesh, edge.corner)));
  const double length = glm::length(across);
  if (length == 0) return;
  const double weight = kind == EdgeKind::kBoundary ? kBoundaryWeight : kSeamWeight;
  const glm::dvec3 unit = across / length;
  Quadric plane;
  plane.addPlane(unit, -glm::dot(unit, mesh.point(edge.u)), weight * glm::dot(along, along));
  mesh.quadrics[edge.u] += plane;
  mesh.quadrics[edge.v] += plane;
}

}  // namespace lode::ingest
