#include "server/ingest/nodes/treelet_plan.h"

#include <utility>

#include "server/ingest/disk/record_bytes.h"

namespace lode::ingest {
namespace {

constexpr uint32_t kNone = ~0u;

}  // namespace

TreeletPlan::TreeletPlan(const TreePlan& tree, std::span<const LeafOfTreelet> leaves, const Digest& settings)
    : tree_(tree), treelet_of_(tree.size()) {
  findRoots();
  listBelow();
  computeNames(leaves, settings);
}

void TreeletPlan::findRoots() {
  const auto nodes = static_cast<uint32_t>(tree_.size());
  std::vector<uint32_t> leaves(nodes);  // number of leaves below each node
  for (uint32_t node = 0; node < nodes; ++node) {
    if (tree_.isLeaf(node)) leaves[node] = 1;
    if (tree_.isRoot(node) || leaves[node] > kMaxLeavesInside) treelets_.emplace_back().root = node;
    if (!tree_.isRoot(node)) leaves[tree_.parent(node)] += leaves[node];
  }
  above_.resize(treelets_.size());
  auto treelet = static_cast<uint32_t>(treelets_.size());
  for (uint32_t node = nodes; node-- > 0;) {
    const bool is_root = treelet > 0 && treelets_[treelet - 1].root == node;
    if (is_root) --treelet;
    if (is_root && !tree_.isRoot(node)) above_[treelet] = treelet_of_[tree_.parent(node)];
    treelet_of_[node] = is_root ? treelet : treelet_of_[tree_.parent(node)];
    ++treelets_[treelet_of_[node]].nodes;
  }
}

/// Lists the treelets below each treelet.
void TreeletPlan::listBelow() {
  first_below_.assign(treelets_.size(), kNone);
  next_beside_.assign(treelets_.size(), kNone);
  for (auto number = static_cast<uint32_t>(treelets_.size() - 1); number-- > 0;)
    next_beside_[number] = std::exchange(first_below_[above_[number]], number);
}

void TreeletPlan::computeNames(std::span<const LeafOfTreelet> leaves, const Digest& settings) {
  std::vector<RecordWriter> records(treelets_.size());
  for (uint32_t node = 0; node < tree_.size(); ++node) {
    const uint32_t number = treelet_of_[node];
    Treelet& treelet = treelets_[number];
    if (tree_.isLeaf(node)) {
      const LeafOfTreelet& leaf = leaves[tree_.leaf(node)];
      records[number].put(tree_.key(node));
      records[number].put(leaf.digest);
      treelet.leaf_bytes += leaf.bytes;
    }
    if (treelet.root != node) continue;
    records[number].put(tree_.key(node));
    records[number].put(settings);
    treelet.name = digestOf(records[number].bytes());
    records[number] = {};
    if (tree_.isRoot(node)) continue;
    records[above_[number]].put(treelet.name);
    treelets_[above_[number]].leaf_bytes += treelet.leaf_bytes;
  }
}

std::vector<uint32_t> TreeletPlan::below(uint32_t number) const {
  std::vector<uint32_t> found;
  for (uint32_t below = first_below_[number]; below != kNone; below = next_beside_[below])
    found.push_back(below);
  return found;
}

}  // namespace lode::ingest
