#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "server/ingest/mesh/vertex_set.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

/// A batch of faces of a packed input. The faces and the data of their vertices fit in a memory limit. One
/// sequential pass over the vertex file visits the vertices, without a sort or random access. Call read()
/// from one thread; the other functions are thread safe.
class FaceBatch {
 public:
  /// @param member_bytes  memory per member. A member is a vertex that the batch's faces use.
  FaceBatch(const PackedInput& input, uint64_t memory_bytes, uint64_t member_bytes)
      : input_(input), used_(input.vertexCount()), memory_bytes_(memory_bytes), member_bytes_(member_bytes) {}

  /// Reads at least one block of faces, and more until the memory is full. @return false if no faces are
  /// left.
  bool read(PackedInput::FaceCursor& cursor);
  const std::vector<PackedInput::FaceBlock>& blocks() const noexcept { return blocks_; }
  /// Returns the number of members.
  uint64_t members() const noexcept { return members_; }
  /// Returns the number of members with smaller vertex indices than `corner`.
  uint32_t rank(uint32_t corner) const noexcept { return used_.rank(corner); }

  /// Calls take(index, position, attributes) for each member with a vertex index in begin..end, in increasing
  /// order.
  /// @param begin, end  multiples of kSweepVertices; `end` can also be the vertex count. Thread safe.
  template <typename Take>
  void sweep(uint64_t begin, uint64_t end, Take&& take) const {
    const auto takeMember = [&](uint64_t number, glm::dvec3 position, const VertexAttributes& attributes) {
      if (used_.contains(number)) take(number, position, attributes);
    };
    while (begin < end) {
      uint64_t needed = begin;
      while (needed < end && isNeeded(needed)) needed += kSweepVertices;
      if (needed > begin) input_.readVertices(begin, std::min(needed, end) - begin, takeMember);
      begin = needed + kSweepVertices;
    }
  }

  static constexpr uint64_t kSweepVertices = 4096;  ///< vertices that sweep() reads or skips at once

 private:
  bool isNeeded(uint64_t first) const noexcept;

  const PackedInput& input_;
  VertexSet used_;
  const uint64_t memory_bytes_, member_bytes_;
  uint64_t members_ = 0;
  std::vector<PackedInput::FaceBlock> blocks_;
};

/// Calls visit(first, corners) for each face of a block, with the index of the face's first corner and the
/// number of corners.
template <typename Visit>
void forEachFace(const PackedInput::FaceBlock& block, Visit&& visit) {
  size_t first = 0;
  for (size_t face = 0; face < block.faceCount(); ++face) {
    const uint32_t corners = block.corner_counts.empty() ? 3 : block.corner_counts[face];
    visit(first, corners);
    first += corners;
  }
}

}  // namespace lode::ingest
