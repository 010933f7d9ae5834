#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/node_key.h"

namespace lode::ingest {

/// Cuts a stream of triangles, sorted by cell code, into the leaves of the adaptive octree. Leaves are the
/// largest cells with at most a given number of triangles. The cutter reads ahead by only one leaf, so that
/// its memory is bounded.
class LeafCutter {
 public:
  /// A function that receives a leaf and the records of its triangles, in the order of push().
  using Sink = std::function<void(NodeKey leaf, std::span<const std::byte> records, uint32_t triangles)>;

  /// @param max_triangles  limit per leaf; leaves of depth 20 can have up to kMaxLodTriangles.
  LeafCutter(size_t record_bytes, uint32_t max_triangles, Sink sink);

  /// Adds a triangle. @throws Error kInput if more than kMaxLodTriangles triangles lie in one cell of
  /// depth 20.
  void push(uint64_t code, std::span<const std::byte> record);
  void finish();

 private:
  void cutOne();

  const size_t record_bytes_;
  const uint32_t max_triangles_;
  const Sink sink_;
  std::vector<uint64_t> codes_;
  std::vector<std::byte> records_;
  size_t begin_ = 0;  ///< index of the first triangle that is in no leaf yet
  bool any_cut_ = false;
  uint64_t last_cut_ = 0;  ///< code of the triangle before begin_
  bool finished_ = false;
};

}  // namespace lode::ingest
