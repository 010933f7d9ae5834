#include "server/ingest/partition/leaf_cutter.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/error.h"
#include "common/limits.h"
#include "server/ingest/mesh/cell_code.h"

namespace lode::ingest {

LeafCutter::LeafCutter(size_t record_bytes, uint32_t max_triangles, Sink sink)
    : record_bytes_(record_bytes), max_triangles_(max_triangles), sink_(std::move(sink)) {}

void LeafCutter::push(uint64_t code, std::span<const std::byte> record) {
  codes_.push_back(code);
  records_.insert(records_.end(), record.begin(), record.end());
  while (codes_.size() - begin_ > max_triangles_) {
    const size_t before = begin_;
    cutOne();
    if (begin_ == before) break;  // the leaf is a cell of depth 20 whose last triangle is not read yet
  }
  if (begin_ > 4 * static_cast<size_t>(max_triangles_)) {
    codes_.erase(codes_.begin(), codes_.begin() + static_cast<ptrdiff_t>(begin_));
    records_.erase(records_.begin(), records_.begin() + static_cast<ptrdiff_t>(begin_ * record_bytes_));
    begin_ = 0;
  }
}

void LeafCutter::finish() {
  finished_ = true;
  while (begin_ < codes_.size()) cutOne();
}

/// Cuts off the leaf at begin_: the largest cell that contains neither the last triangle of the previous leaf
/// nor the first triangle that would exceed the maximum.
void LeafCutter::cutOne() {
  const uint64_t first = codes_[begin_];
  int depth = any_cut_ ? commonDepth(last_cut_, first) + 1 : 0;
  if (begin_ + max_triangles_ < codes_.size()) {
    depth = std::max(depth, commonDepth(first, codes_[begin_ + max_triangles_]) + 1);
  }
  depth = std::min(depth, kMaxDepth);
  const NodeKey leaf = cellAt(first, depth);
  const auto end = std::partition_point(codes_.begin() + static_cast<ptrdiff_t>(begin_), codes_.end(),
                                        [&](uint64_t code) { return cellAt(code, depth) == leaf; });
  const size_t triangles = static_cast<size_t>(end - codes_.begin()) - begin_;
  if (triangles > kMaxLodTriangles) {
    throw Error(ErrorCode::kInput, "more than " + std::to_string(kMaxLodTriangles) +
                                       " triangles lie in cell " + std::to_string(leaf.value) +
                                       " of the finest level; remove duplicate triangles from the input");
  }
  if (end == codes_.end() && !finished_ && depth == kMaxDepth && triangles > max_triangles_) return;
  sink_(leaf, std::span(records_).subspan(begin_ * record_bytes_, triangles * record_bytes_),
        static_cast<uint32_t>(triangles));
  begin_ += triangles;
  any_cut_ = true;
  last_cut_ = first;
}

}  // namespace lode::ingest
