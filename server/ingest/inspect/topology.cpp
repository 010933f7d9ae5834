#include "server/ingest/inspect/topology.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "common/octahedral.h"
#include "server/ingest/mesh/groups.h"
#include "server/ingest/mesh/number_table.h"
#include "server/ingest/mesh/vertex_set.h"
#include "server/ingest/soup/lattice_choice.h"

namespace lode::ingest {
namespace {

constexpr uint64_t kMaxVertices = uint64_t{1} << 31;  ///< an edge and its direction take 63 bits
constexpr uint32_t kNone = UINT32_MAX;

/// A hash of a place, -0 and 0 being the same.
uint64_t hashOf(glm::dvec3 position) noexcept {
  uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    hash = NumberTable::hash(hash * 31 + std::bit_cast<uint64_t>(position[axis] + 0.0));
  }
  return hash;
}

}  // namespace

/// Bytes a vertex: place, normal, its slots in the table that joins, its piece. Bytes a corner: its number,
/// its edge.
bool TopologyCounter::fits(uint64_t vertices, uint64_t faces, uint64_t corners) {
  constexpr uint64_t kVertexBytes =
      sizeof(glm::dvec3) + sizeof(uint16_t) + 4 * sizeof(uint32_t) + 2 * sizeof(uint32_t);
  constexpr uint64_t kCornerBytes = sizeof(uint32_t) + sizeof(uint64_t);
  const uint64_t bytes = vertices * kVertexBytes + corners * kCornerBytes + faces * sizeof(uint32_t);
  if (bytes <= memory_bytes_ && vertices < kMaxVertices) return true;
  is_too_large_ = true;
  positions_ = {};
  normals_ = {};
  corner_counts_ = {};
  corners_ = {};
  return false;
}

void TopologyCounter::addVertices(std::span<const PlyVertex> vertices, bool has_normals) {
  if (is_too_large_ || !fits(positions_.size() + vertices.size(), 0, 0)) return;
  for (const PlyVertex& vertex : vertices) {
    positions_.push_back(vertex.position);
    if (has_normals) normals_.push_back(encodeOctahedral(vertex.normal));
  }
}

void TopologyCounter::addFaces(const PlyFaces& faces) {
  if (is_too_large_ || !fits(positions_.size(), corner_counts_.size() + faces.corner_counts.size(),
                             corners_.size() + faces.corners.size())) {
    return;
  }
  corner_counts_.insert(corner_counts_.end(), faces.corner_counts.begin(), faces.corner_counts.end());
  for (const uint64_t corner : faces.corners) corners_.push_back(static_cast<uint32_t>(corner));
}

std::optional<Topology> TopologyCounter::count() {
  if (is_too_large_) return std::nullopt;
  countUsed();
  if (!normals_.empty()) countOpposed();
  joinVertices();
  countPieces();
  countLost();
  positions_ = {};
  countEdges();
  return topology_;
}

void TopologyCounter::countUsed() {
  VertexSet used(positions_.size());
  uint64_t members = 0;
  topology_.used_min = glm::dvec3(std::numeric_limits<double>::max());
  topology_.used_max = -topology_.used_min;
  for (const uint32_t corner : corners_) {
    if (!used.add(corner)) continue;
    ++members;
    topology_.used_min = glm::min(topology_.used_min, positions_[corner]);
    topology_.used_max = glm::max(topology_.used_max, positions_[corner]);
  }
  if (members == 0) topology_.used_min = topology_.used_max = glm::dvec3(0);
  topology_.unused_vertices = positions_.size() - members;
}

/// Before vertices are joined: those at one place may have several normals.
void TopologyCounter::countOpposed() {
  size_t first = 0;
  for (const uint32_t corners : corner_counts_) {
    const auto at = [&](size_t corner) { return positions_[corners_[first + corner]]; };
    glm::dvec3 front(0), mean(0);
    for (size_t c = 0; c < corners; ++c) {
      if (c >= 2) front += glm::cross(at(c - 1) - at(0), at(c) - at(0));
      mean += glm::dvec3(decodeOctahedral(normals_[corners_[first + c]]));
    }
    topology_.opposed_faces += glm::dot(front, mean) < 0;
    first += corners;
  }
  normals_ = {};
}

/// Makes all corners at one place the first vertex there.
void TopologyCounter::joinVertices() {
  const size_t slots = std::bit_ceil(positions_.size() * 2 + 1);
  std::vector<uint32_t> table(slots, kNone), first(positions_.size());
  for (uint32_t v = 0; v < positions_.size(); ++v) {
    size_t at = hashOf(positions_[v]) & (slots - 1);
    while (table[at] != kNone && positions_[table[at]] != positions_[v]) at = (at + 1) & (slots - 1);
    if (table[at] == kNone) {
      table[at] = v;
    } else {
      ++topology_.duplicate_vertices;
    }
    first[v] = table[at];
  }
  for (uint32_t& corner : corners_) corner = first[corner];
}

void TopologyCounter::countPieces() {
  Groups joined(positions_.size());
  VertexSet used(positions_.size());
  size_t first = 0;
  for (const uint32_t corners : corner_counts_) {
    for (size_t c = first; c < first + corners; ++c) {
      topology_.pieces += used.add(corners_[c]);
      topology_.pieces -= joined.join(corners_[first], corners_[c]);
    }
    first += corners;
  }
}

void TopologyCounter::countLost() {
  const glm::dvec3 box_min = topology_.used_min, box_max = topology_.used_max;
  if (box_min == box_max) return;
  const auto positionOf = [this](uint32_t vertex) { return positions_[vertex]; };
  const auto forEachFace = [this](auto&& visit) {
    size_t first = 0;
    for (size_t f = 0; f < corner_counts_.size(); first += corner_counts_[f++])
      visit(f, std::span<const uint32_t>(corners_).subspan(first, corner_counts_[f]));
  };
  const uint64_t stride = faceStride(corner_counts_.size());
  std::vector<SampledFace> faces;
  forEachFace([&](size_t f, std::span<const uint32_t> corners) {
    if (f % stride == 0) faces.push_back(sampledFace(corners));
  });
  const Lattice lattice = chooseLattice(faces, positionOf, box_min, box_max);
  topology_.lattice_step = lattice.step;
  forEachFace([&](size_t, std::span<const uint32_t> corners) {
    topology_.lost_faces += isLost(corners, positionOf, lattice);
  });
}

void TopologyCounter::countEdges() {
  std::vector<uint64_t> edges;  // both ends, and the direction in the lowest bit
  edges.reserve(corners_.size());
  size_t first = 0;
  for (const uint32_t corners : corner_counts_) {
    size_t sides = 0;
    for (size_t c = 0; c < corners; ++c) {
      const uint64_t from = corners_[first + c], to = corners_[first + (c + 1) % corners];
      if (from == to) continue;
      ++sides;
      edges.push_back(std::min(from, to) << 32 | std::max(from, to) << 1 | (from < to));
    }
    if (sides < 3) {
      edges.resize(edges.size() - sides);
      ++topology_.flat_faces;
    }
    first += corners;
  }
  corners_ = {};
  std::sort(edges.begin(), edges.end());
  for (size_t i = 0; i < edges.size();) {
    size_t end = i + 1;
    while (end < edges.size() && edges[end] >> 1 == edges[i] >> 1) ++end;
    topology_.open_edges += end - i == 1;
    topology_.non_manifold_edges += end - i > 2;
    topology_.misoriented_edges += end - i == 2 && edges[i] == edges[i + 1];
    i = end;
  }
}

}  // namespace lode::ingest
