#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/codec/blob.h"
#include "common/node_key.h"
#include "server/ingest/nodes/treelet_plan.h"

namespace lode::test {

inline Digest digest(std::string_view text) { return digestOf(std::as_bytes(std::span(text))); }

/// All leaves of a full octree, of varying sizes.
struct LeavesOfTree {
  /// @param depth  depth of the leaves.
  explicit LeavesOfTree(int depth) { add(kRootKey, depth); }

  std::vector<NodeKey> keys;
  std::vector<ingest::LeafOfTreelet> marks;

 private:
  void add(NodeKey key, int depth) {
    if (key.depth() == depth) {
      keys.push_back(key);
      marks.push_back({digest(std::to_string(key.value)), 1000 + key.value * 7919 % 1000});
      return;
    }
    for (unsigned octant = 0; octant < 8; ++octant) add(key.child(octant), depth);
  }
};

}  // namespace lode::test
