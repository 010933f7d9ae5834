#include "server/ingest/soup/dereference.h"

#include <algorithm>

#include "server/ingest/mesh/vertex_set.h"
#include "server/ingest/soup/triangulate.h"

namespace lode::ingest {
namespace {

constexpr uint64_t kSweepVertices = 4096;  ///< read, or skipped, at once

/// Faces of one batch, and the vertices that they use.
class Batch {
 public:
  Batch(const PackedInput& input, const Lattice& lattice, uint64_t memory_bytes)
      : input_(input),
        lattice_(lattice),
        used_(input.vertexCount()),
        memory_bytes_(memory_bytes),
        member_bytes_(sizeof(PositionCode) + (input.hasVertexAttributes() ? sizeof(VertexAttributes) : 0)) {}

  /// Reads faces until the memory is full, one block at least. @return false if there were none left.
  bool readFaces(PackedInput::FaceCursor& cursor) {
    used_.clear();
    blocks_.clear();
    uint64_t members = 0;
    PackedInput::FaceBlock block;
    uint64_t face_bytes = 0;
    const auto isFull = [&] { return face_bytes + members * member_bytes_ >= memory_bytes_; };
    while ((blocks_.empty() || !isFull()) && cursor.next(block)) {
      for (const uint32_t corner : block.corners) members += used_.add(corner);
      face_bytes += block.bytes();
      blocks_.push_back(std::move(block));
      block = {};
    }
    return !blocks_.empty();
  }

  void sweepVertices(DereferenceCounts& counts) {
    const uint64_t members = used_.countRanks();
    positions_.resize(members);
    if (input_.hasVertexAttributes()) attributes_.resize(members);
    uint64_t next = 0;
    const auto take = [&](uint64_t number, glm::dvec3 position, const VertexAttributes& attributes) {
      if (!used_.contains(number)) return;
      const glm::uvec3 snapped = lattice_.snap(position);
      positions_[next] = packPosition(snapped);
      counts.snap_error_steps = std::max(counts.snap_error_steps,
                                         glm::distance(position, lattice_.toWorld(snapped)) / lattice_.step);
      if (!attributes_.empty()) attributes_[next] = attributes;
      ++next;
    };
    uint64_t first = 0;
    while (first < input_.vertexCount()) {
      uint64_t end = first;
      while (end < input_.vertexCount() && isNeeded(end)) end += kSweepVertices;
      if (end > first) input_.readVertices(first, std::min(end, input_.vertexCount()) - first, take);
      first = end + kSweepVertices;
    }
  }

  const std::vector<PackedInput::FaceBlock>& blocks() const noexcept { return blocks_; }

  /// Gives out the triangles of a block's faces.
  void giveOut(const PackedInput::FaceBlock& block, DereferenceCounts& counts, const SoupSink& sink) {
    uint32_t first = 0;
    for (size_t f = 0; f < block.faceCount(); ++f) {
      const uint32_t corners = block.corner_counts.empty() ? 3 : block.corner_counts[f];
      const uint16_t material = block.materials.empty() ? uint16_t{0} : block.materials[f];
      giveOut(block, first, corners, material, counts, sink);
      first += corners;
    }
  }

 private:
  void giveOut(const PackedInput::FaceBlock& block, uint32_t first, uint32_t corners, uint16_t material,
               DereferenceCounts& counts, const SoupSink& sink) {
    if (corners == 3) {
      giveOut(block, glm::u32vec3(first, first + 1, first + 2), material, counts, sink);
      return;
    }
    outline_.clear();
    for (uint32_t c = first; c < first + corners; ++c)
      outline_.emplace_back(unpackPosition(positions_[used_.rank(block.corners[c])]));
    triangulate(outline_, cut_);
    for (const glm::u32vec3& t : cut_) giveOut(block, first + t, material, counts, sink);
  }

  /// Of a triangle that was dropped. Few are, so that their places are looked up one by one.
  bool isLost(const PackedInput::FaceBlock& block, glm::u32vec3 corners) const {
    const glm::u32vec3 t(block.corners[corners.x], block.corners[corners.y], block.corners[corners.z]);
    if (t.x == t.y || t.y == t.z || t.z == t.x) return false;
    const glm::dvec3 a = input_.positionOf(t.x), b = input_.positionOf(t.y), c = input_.positionOf(t.z);
    return a != b && b != c && c != a;
  }

  bool isNeeded(uint64_t first) const noexcept {
    const uint64_t end = std::min(used_.wordCount(), (first + kSweepVertices) / 64);
    for (uint64_t word = first / 64; word < end; ++word) {
      if (used_.anyInWord(word)) return true;
    }
    return false;
  }

  void giveOut(const PackedInput::FaceBlock& block, glm::u32vec3 corners, uint16_t material,
               DereferenceCounts& counts, const SoupSink& sink) {
    SoupTriangle triangle;
    for (int k = 0; k < 3; ++k) {
      const uint64_t rank = used_.rank(block.corners[corners[k]]);
      triangle.corners[k] = positions_[rank];
      VertexAttributes& attributes = triangle.attributes[k];
      if (!attributes_.empty()) attributes = attributes_[rank];
      if (!block.texture.empty()) attributes.texture = block.texture[corners[k]];
      attributes.material = material;
    }
    if (triangle.corners[0] == triangle.corners[1] || triangle.corners[1] == triangle.corners[2] ||
        triangle.corners[2] == triangle.corners[0]) {
      ++counts.dropped;
      counts.lost += isLost(block, corners);
      return;
    }
    ++counts.triangles;
    sink(triangle);
  }

  const PackedInput& input_;
  const Lattice& lattice_;
  VertexSet used_;
  const uint64_t memory_bytes_;
  const uint64_t member_bytes_;
  std::vector<PackedInput::FaceBlock> blocks_;
  std::vector<PositionCode> positions_;
  std::vector<VertexAttributes> attributes_;
  std::vector<glm::dvec3> outline_;
  std::vector<glm::u32vec3> cut_;
};

}  // namespace

DereferenceCounts dereference(const PackedInput& input, const Lattice& lattice, uint64_t memory_bytes,
                              const SoupSink& sink, const BuildProgress& progress,
                              const DereferencePoint& from, const BatchSink& on_batch) {
  DereferenceCounts counts = from.counts;
  PackedInput::FaceCursor cursor(input, from.face_offset);
  Batch batch(input, lattice, memory_bytes / 2);
  uint64_t faces = from.faces, begin = cursor.offset();
  for (; batch.readFaces(cursor); begin = cursor.offset()) {
    if (on_batch) on_batch({begin, faces, counts});
    batch.sweepVertices(counts);
    for (const PackedInput::FaceBlock& block : batch.blocks()) {
      batch.giveOut(block, counts, sink);
      faces += block.faceCount();
      if (progress) {
        progress("dereference", static_cast<double>(faces) / static_cast<double>(input.faceCount()), faces,
                 input.faceCount());
      }
    }
  }
  return counts;
}

}  // namespace lode::ingest
