#include "server/ingest/inspect/topology.h"

#include <algorithm>
#include <utility>

#include "common/codec/octahedral.h"
#include "server/ingest/soup/lattice_choice.h"

namespace lode::ingest {
namespace {

/// The memory budget is split into this many equal shares: sorting, a batch of faces, counting pieces, and
/// everything else.
constexpr uint64_t kShares = 4;

AttributeSet normalsOf(AttributeSet attributes) noexcept {
  AttributeSet normals;
  normals.bits = attributes.bits & AttributeSet::kNormal;
  return normals;
}

}  // namespace

TopologyCounter::TopologyCounter(const TemporaryFolder& folder, AttributeSet attributes,
                                 bool double_positions, uint64_t memory_bytes)
    : folder_(folder),
      has_normals_(attributes.has(AttributeSet::kNormal)),
      memory_bytes_(memory_bytes),
      input_(folder, normalsOf(attributes), double_positions),
      places_(folder, memory_bytes / kShares),
      edges_(sizeof(uint8_t), memory_bytes / kShares, folder.file("edges")) {}

void TopologyCounter::addVertices(std::span<const PlyVertex> vertices) {
  auto number = static_cast<uint32_t>(input_.vertexCount());
  for (const PlyVertex& vertex : vertices) places_.add(number++, vertex.position);
  input_.addVertices(vertices);
}

void TopologyCounter::addFaces(const PlyFaces& faces) { input_.addFaces(faces); }

Topology TopologyCounter::count() {
  input_.flush();
  countVertices();
  countFaces();
  countEdges();
  return topology_;
}

void TopologyCounter::countVertices() {
  topology_.duplicate_vertices = places_.find();
  const UsedVertices used = findUsedVertices(input_);
  topology_.unused_vertices = input_.vertexCount() - used.count;
  if (used.count == 0) return;
  topology_.used_min = used.min;
  topology_.used_max = used.max;
  const LatticeOrProblem chosen = chooseLattice(used);
  topology_.lattice_problem = chosen.problem;
  if (!chosen.lattice) return;
  lost_.emplace(*chosen.lattice);
  topology_.lattice_step = chosen.lattice->step;
}

void TopologyCounter::countFaces() {
  pieces_.emplace(input_.vertexCount(), memory_bytes_ / kShares, folder_);
  used_.emplace(input_.vertexCount());
  FaceBatch batch(input_, memory_bytes_ / kShares, sizeof(Member));
  PackedInput::FaceCursor cursor(input_);
  while (batch.read(cursor)) {
    sweep(batch);
    for (const PackedInput::FaceBlock& block : batch.blocks())
      forEachFace(block, [&](size_t first, size_t corners) {
        face_.clear();
        for (size_t c = first; c < first + corners; ++c)
          face_.push_back(members_[batch.rank(block.corners[c])]);
        countFace();
      });
  }
  topology_.pieces -= pieces_->countJoins();
  pieces_.reset();
}

void TopologyCounter::sweep(const FaceBatch& batch) {
  members_.clear();
  members_.reserve(batch.members());
  SamePlaces::Cursor places(places_);
  batch.sweep(
      0, input_.vertexCount(), [&](uint64_t number, glm::dvec3 position, const VertexAttributes& attributes) {
        members_.push_back({position, places.firstAt(static_cast<uint32_t>(number)), attributes.normal});
      });
}

void TopologyCounter::countFace() {
  if (has_normals_) topology_.opposed_faces += isOpposed();
  corners_.clear();
  for (const Member& corner : face_) {
    corners_.push_back(corner.position);
    topology_.pieces += used_->add(corner.first);
    pieces_->join(face_.front().first, corner.first);
  }
  if (lost_) topology_.lost_triangles += lost_->count(corners_);
  addEdges();
}

/// Returns true if the mean normal of the current face's vertices points to the face's back. Uses the face's
/// own vertices, because vertices at one position may have different normals.
bool TopologyCounter::isOpposed() const {
  glm::dvec3 front(0), mean(0);
  for (size_t c = 0; c < face_.size(); ++c) {
    const glm::dvec3 from = face_[0].position;
    if (c >= 2) front += glm::cross(face_[c - 1].position - from, face_[c].position - from);
    if (face_[c].normal != kNoNormal) mean += glm::dvec3(decodeOctahedral(face_[c].normal));
  }
  return glm::dot(front, mean) < 0;
}

void TopologyCounter::addEdges() {
  const auto end = [&](size_t c) { return uint64_t{face_[c % face_.size()].first}; };
  size_t sides = 0;
  for (size_t c = 0; c < face_.size(); ++c) sides += end(c) != end(c + 1);
  if (sides < 3) {
    ++topology_.flat_faces;
    return;
  }
  for (size_t c = 0; c < face_.size(); ++c) {
    const uint64_t from = end(c), to = end(c + 1);
    const uint8_t direction = from < to;
    if (from != to)
      edges_.push(std::min(from, to) << 32 | std::max(from, to), std::as_bytes(std::span(&direction, 1)));
  }
}

void TopologyCounter::countEdges() {
  edges_.finish();
  uint64_t key = 0, uses = 0, forward = 0;
  std::vector<uint32_t> ends;  // vertices of open edges
  const auto countOne = [&] {
    if (uses == 1 && topology_.open_edges++ < kMaxBorderEdges)
      ends.insert(ends.end(), {static_cast<uint32_t>(key >> 32), static_cast<uint32_t>(key)});
    topology_.non_manifold_edges += uses > 2;
    topology_.misoriented_edges += uses == 2 && forward != 1;
    uses = forward = 0;
  };
  while (const auto use = edges_.next()) {
    if (use->key != key) countOne();
    key = use->key;
    ++uses;
    forward += static_cast<uint8_t>(use->bytes[0]);
  }
  countOne();
  placeBorder(std::move(ends));
}

/// Reads the positions of the ends of open edges. @param ends  two vertices for each edge.
void TopologyCounter::placeBorder(std::vector<uint32_t> ends) {
  OpenBorder& border = topology_.border;
  for (size_t i = 0; i < ends.size(); i += 2)
    border.edge_model += glm::distance(input_.positionOf(ends[i]), input_.positionOf(ends[i + 1]));
  if (!ends.empty()) border.edge_model /= static_cast<double>(ends.size()) / 2;
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  for (const uint32_t end : ends) border.places.push_back(input_.positionOf(end));
}

}  // namespace lode::ingest
