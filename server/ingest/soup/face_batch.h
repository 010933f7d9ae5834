#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "server/ingest/mesh/vertex_set.h"
#include "server/ingest/soup/packed_input.h"

namespace lode::ingest {

/// As many of a packed input's faces as a bounded memory holds with what is wanted of their vertices, which
/// one sweep over the file gives in their order: no sort, and no look at the file for each corner. To be read
/// by one thread, and looked up by any.
class FaceBatch {
 public:
  /// @param member_bytes  of memory, for each vertex that the faces use.
  FaceBatch(const PackedInput& input, uint64_t memory_bytes, uint64_t member_bytes)
      : input_(input), used_(input.vertexCount()), memory_bytes_(memory_bytes), member_bytes_(member_bytes) {}

  /// Reads faces until the memory is full, one block at least. @return false if there were none left.
  bool read(PackedInput::FaceCursor& cursor);
  const std::vector<PackedInput::FaceBlock>& blocks() const noexcept { return blocks_; }
  /// Vertices that they use.
  uint64_t members() const noexcept { return members_; }
  /// The place of a corner's vertex among those.
  uint32_t rank(uint32_t corner) const noexcept { return used_.rank(corner); }

  /// Calls take(number, position, attributes) for each member of vertices begin..end, in rising order.
  /// @param begin, end  multiples of kSweepVertices, or the last of all. Thread safe.
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

  static constexpr uint64_t kSweepVertices = 4096;  ///< read, or skipped, at once

 private:
  bool isNeeded(uint64_t first) const noexcept;

  const PackedInput& input_;
  VertexSet used_;
  const uint64_t memory_bytes_, member_bytes_;
  uint64_t members_ = 0;
  std::vector<PackedInput::FaceBlock> blocks_;
};

/// Calls visit(first, corners) for each face of a block: where its corners begin, and how many there are.
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
