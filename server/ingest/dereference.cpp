#include "server/ingest/dereference.h"

#include <algorithm>

#include "server/ingest/triangulate.h"
#include "server/ingest/vertex_set.h"

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
        member_bytes_(sizeof(PositionCode) + (input.attributes().bits ? sizeof(VertexAttributes) : 0)) {}

  /// Reads faces until the memory is full, one block at least. @return false if there were none left.
  bool readFaces(PackedInput::FaceCursor& cursor) {
    used_.clear();
    blocks_.clear();
    uint64_t members = 0, corners = 0;
    PackedInput::FaceBlock block;
    const auto isFull = [&] { return corners * sizeof(uint32_t) + members * member_bytes_ >= memory_bytes_; };
    while ((blocks_.empty() || !isFull()) && cursor.next(block)) {
      for (const uint32_t corner : block.corners) members += used_.add(corner);
      corners += block.corners.size();
      blocks_.push_back(std::move(block));
      block = {};
    }
    return !blocks_.empty();
  }

  void sweepVertices() {
    const uint64_t members = used_.countRanks();
    positions_.resize(members);
    if (input_.attributes().bits != 0) attributes_.resize(members);
    uint64_t next = 0;
    const auto take = [&](uint64_t number, glm::dvec3 position, const VertexAttributes& attributes) {
      if (!used_.contains(number)) return;
      positions_[next] = packPosition(lattice_.snap(position));
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

  /// Gives out a face's triangles.
  void giveOut(std::span<const uint32_t> corners, DereferenceCounts& counts, const SoupSink& sink) {
    if (corners.size() == 3) {
      giveOut(corners[0], corners[1], corners[2], counts, sink);
      return;
    }
    outline_.clear();
    for (const uint32_t corner : corners)
      outline_.emplace_back(unpackPosition(positions_[used_.rank(corner)]));
    triangulate(outline_, cut_);
    for (const glm::u32vec3& t : cut_) giveOut(corners[t.x], corners[t.y], corners[t.z], counts, sink);
  }

 private:
  bool isNeeded(uint64_t first) const noexcept {
    const uint64_t end = std::min(used_.wordCount(), (first + kSweepVertices) / 64);
    for (uint64_t word = first / 64; word < end; ++word) {
      if (used_.anyInWord(word)) return true;
    }
    return false;
  }

  void giveOut(uint32_t a, uint32_t b, uint32_t c, DereferenceCounts& counts, const SoupSink& sink) {
    const uint64_t ranks[3] = {used_.rank(a), used_.rank(b), used_.rank(c)};
    SoupTriangle triangle;
    for (int k = 0; k < 3; ++k) {
      triangle.corners[k] = positions_[ranks[k]];
      if (!attributes_.empty()) triangle.attributes[k] = attributes_[ranks[k]];
    }
    if (triangle.corners[0] == triangle.corners[1] || triangle.corners[1] == triangle.corners[2] ||
        triangle.corners[2] == triangle.corners[0]) {
      ++counts.dropped;
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
                              const SoupSink& sink, const BuildProgress& progress) {
  DereferenceCounts counts;
  PackedInput::FaceCursor cursor(input);
  Batch batch(input, lattice, memory_bytes / 2);
  uint64_t faces = 0;
  while (batch.readFaces(cursor)) {
    batch.sweepVertices();
    for (const PackedInput::FaceBlock& block : batch.blocks()) {
      size_t first = 0;
      for (size_t f = 0; f < block.faceCount(); ++f) {
        const size_t corners = block.corner_counts.empty() ? 3 : block.corner_counts[f];
        batch.giveOut(std::span(block.corners).subspan(first, corners), counts, sink);
        first += corners;
      }
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
