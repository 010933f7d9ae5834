#include "server/ingest/soup/face_batch.h"

#include <utility>

namespace lode::ingest {

bool FaceBatch::read(PackedInput::FaceCursor& cursor) {
  used_.clear();
  blocks_.clear();
  members_ = 0;
  PackedInput::FaceBlock block;
  uint64_t face_bytes = 0;
  const auto isFull = [&] { return face_bytes + members_ * member_bytes_ >= memory_bytes_; };
  while ((blocks_.empty() || !isFull()) && cursor.next(block)) {
    for (const uint32_t corner : block.corners) members_ += used_.add(corner);
    face_bytes += block.bytes();
    blocks_.push_back(std::move(block));
    block = {};
  }
  used_.countRanks();
  return !blocks_.empty();
}

bool FaceBatch::isNeeded(uint64_t first) const noexcept {
  const uint64_t end = std::min(used_.wordCount(), (first + kSweepVertices) / 64);
  for (uint64_t word = first / 64; word < end; ++word)
    if (used_.anyInWord(word)) return true;
  return false;
}

}  // namespace lode::ingest
