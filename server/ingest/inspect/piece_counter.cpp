#include "server/ingest/inspect/piece_counter.h"

#include <algorithm>
#include <array>
#include <span>
#include <string>

namespace lode::ingest {
namespace {

constexpr uint32_t kNone = UINT32_MAX;
constexpr uint64_t kVertexBytes = 2 * sizeof(uint32_t);  ///< memory per vertex, for its group and its anchor
constexpr uint64_t kLeastVertices = 1024;                ///< smallest number of vertices in a range

}  // namespace

PieceCounter::PieceCounter(uint64_t vertices, uint64_t memory_bytes, const TemporaryFolder& folder)
    : range_vertices_(std::clamp(memory_bytes / kVertexBytes, kLeastVertices,
                                 std::max<uint64_t>(vertices, kLeastVertices))) {
  const auto ranges = static_cast<size_t>((vertices + range_vertices_ - 1) / range_vertices_);
  for (size_t range = 0; range + 1 < ranges; ++range)
    lower_.push_back(std::make_unique<Spool>(folder.file("joins-" + std::to_string(range))));
  open(lower_.size());
}

void PieceCounter::open(size_t range) {
  range_ = range;
  groups_ = Groups(range_vertices_);
  anchors_.assign(range_vertices_, kNone);
}

void PieceCounter::join(uint32_t a, uint32_t b) {
  if (a != b) handDown(a, b);
}

/// Passes a join to the range that contains its larger index: the current range or a later one.
void PieceCounter::handDown(uint32_t a, uint32_t b) {
  const Join join{std::max(a, b), std::min(a, b)};
  const auto range = static_cast<size_t>(join.high / range_vertices_);
  if (range == range_) return joinInRange(join);
  lower_[range]->append(std::span<const Join>(&join, 1));
}

void PieceCounter::joinInRange(Join join) {
  const uint64_t first = range_ * range_vertices_;
  const uint32_t high = groups_.find(static_cast<uint32_t>(join.high - first));
  const uint32_t anchor = anchors_[high];
  if (join.low < first) {
    if (anchor == kNone) {
      anchors_[high] = join.low;
      ++joins_;
    } else if (anchor != join.low) {
      handDown(anchor, join.low);
    }
    return;
  }
  const uint32_t low = groups_.find(static_cast<uint32_t>(join.low - first));
  if (!groups_.join(high, low)) return;
  const uint32_t other = anchors_[low];
  uint32_t& common = anchors_[std::min(high, low)];
  common = anchor == kNone ? other : anchor;
  if (anchor == kNone || other == kNone) {
    ++joins_;
  } else if (anchor != other) {
    handDown(anchor, other);  // a later range counts this join
  }
}

uint64_t PieceCounter::countJoins() {
  while (range_ > 0) {
    open(range_ - 1);
    Spool& joins = *lower_[range_];
    joins.flush();
    SpoolCursor cursor(joins, 0, joins.size());
    while (!cursor.atEnd()) {
      std::array<Join, 1> next;
      cursor.take(std::span<Join>(next));
      joinInRange(next[0]);
    }
    lower_.pop_back();
  }
  return joins_;
}

}  // namespace lode::ingest
