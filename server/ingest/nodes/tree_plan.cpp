#include "server/ingest/nodes/tree_plan.h"

#include <algorithm>

namespace lode::ingest {

TreePlan::TreePlan(const std::vector<NodeKey>& leaves) {
  entries_.reserve(leaves.size() + leaves.size() / 4 + kMaxDepth);
  size_t next = 0;
  plan(kRootKey, leaves, next);
}

void TreePlan::plan(NodeKey key, const std::vector<NodeKey>& leaves, size_t& next) {
  Entry entry{key, 0, static_cast<uint32_t>(entries_.size()), static_cast<uint32_t>(next)};
  if (leaves[next] == key) {
    ++next;
  } else {
    for (unsigned octant = 0; octant < 8 && next < leaves.size(); ++octant) {
      const NodeKey child = key.child(octant);
      if (child.contains(leaves[next])) plan(child, leaves, next);
    }
  }
  const auto number = static_cast<uint32_t>(entries_.size());
  entries_.push_back(entry);
  for (const uint32_t child : children(number)) entries_[child].parent = number;
}

/// Finds the children from the last to the first. In post-order, the last child directly precedes the node,
/// and every other child directly precedes the first node of the next child's subtree.
std::vector<uint32_t> TreePlan::children(uint32_t number) const {
  std::vector<uint32_t> result;
  const uint32_t first = entries_[number].first;
  for (uint32_t end = number; end > first; end = entries_[result.back()].first) result.push_back(end - 1);
  std::reverse(result.begin(), result.end());
  return result;
}

}  // namespace lode::ingest
