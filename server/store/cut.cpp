#include "server/store/cut.h"

#include <algorithm>
#include <queue>
#include <random>

namespace lode::store {
namespace {

const Lod& lodOf(const NodeTree& tree, CutItem item) { return tree.node(item.node).lods[item.lod]; }

CutItem coarsest(const NodeTree& tree, uint32_t node) {
  return {node, static_cast<uint32_t>(tree.node(node).lods.size() - 1)};
}

/// Returns the coarsest LOD of a node whose error does not exceed `error`.
CutItem coarsestWithin(const NodeTree& tree, uint32_t node, float error) {
  const std::vector<Lod>& lods = tree.node(node).lods;
  auto lod = static_cast<uint32_t>(lods.size() - 1);
  while (lod > 0 && lods[lod].error_model > error) --lod;
  return {node, lod};
}

/// Sorts the items in Morton order and computes the sums.
Cut finishCut(const NodeTree& tree, std::vector<CutItem> items) {
  const auto cell = [&](CutItem item) {
    const NodeKey key = tree.node(item.node).key;
    return key.value << 3 * (kMaxDepth - key.depth());
  };
  std::sort(items.begin(), items.end(), [&](CutItem a, CutItem b) { return cell(a) < cell(b); });
  Cut cut;
  cut.items = std::move(items);
  for (const CutItem item : cut.items) {
    const Lod& lod = lodOf(tree, item);
    cut.triangles += lod.triangles;
    if (lod.triangles != 0) cut.max_error_model = std::max(cut.max_error_model, lod.error_model);
  }
  return cut;
}

/// Visits nodes from the root down. At each node `choose` returns the LOD for the cut, or a negative number
/// to continue with the children. At a leaf it must return an LOD.
template <typename Choose>
Cut walk(const NodeTree& tree, Choose&& choose) {
  std::vector<CutItem> items;
  std::vector<uint32_t> todo{0};
  while (!todo.empty()) {
    const uint32_t number = todo.back();
    todo.pop_back();
    const int lod = choose(tree.node(number));
    if (lod >= 0) {
      items.push_back({number, static_cast<uint32_t>(lod)});
      continue;
    }
    for (uint32_t i = 0; i < tree.childCount(number); ++i) todo.push_back(tree.firstChild(number) + i);
  }
  return finishCut(tree, std::move(items));
}

}  // namespace

Cut cutByError(const NodeTree& tree, double max_error_model) {
  Cut cut = walk(tree, [&](const Node& node) {
    for (size_t lod = node.lods.size(); lod-- > 0;)
      if (node.lods[lod].error_model <= max_error_model) return static_cast<int>(lod);
    return node.isLeaf() ? 0 : -1;
  });
  cut.converged = cut.max_error_model <= max_error_model;
  return cut;
}

Cut cutByTriangles(const NodeTree& tree, uint64_t max_triangles) {
  struct Candidate {
    float error;
    CutItem item;
    bool operator<(const Candidate& other) const {  // largest error first
      return error != other.error ? error < other.error : item.node > other.item.node;
    }
  };
  std::priority_queue<Candidate> queue;
  std::vector<CutItem> done;
  const auto show = [&](CutItem item) { queue.push({lodOf(tree, item).error_model, item}); };
  show(coarsest(tree, 0));
  uint64_t triangles = lodOf(tree, coarsest(tree, 0)).triangles;
  const bool fits = triangles <= max_triangles;
  while (!queue.empty()) {
    const auto [error, item] = queue.top();
    queue.pop();
    const uint64_t others = triangles - lodOf(tree, item).triangles;
    const uint32_t children = item.lod > 0 ? 0 : tree.childCount(item.node);
    uint64_t refined = others;
    if (item.lod > 0) refined += lodOf(tree, {item.node, item.lod - 1}).triangles;
    for (uint32_t i = 0; i < children; ++i)
      refined += lodOf(tree, coarsestWithin(tree, tree.firstChild(item.node) + i, error)).triangles;
    if ((item.lod == 0 && children == 0) || refined > max_triangles) {
      done.push_back(item);
      continue;
    }
    triangles = refined;
    if (item.lod > 0) show({item.node, item.lod - 1});
    for (uint32_t i = 0; i < children; ++i) show(coarsestWithin(tree, tree.firstChild(item.node) + i, error));
  }
  Cut cut = finishCut(tree, std::move(done));
  cut.converged = fits;
  return cut;
}

Cut randomCut(const NodeTree& tree, uint64_t seed) {
  // Use the generator's output directly: the standard specifies it exactly, but not the output of
  // distributions.
  std::mt19937_64 random(seed);
  const uint64_t stop_of_16 = 1 + random() % 10;
  return walk(tree, [&](const Node& node) {
    const uint64_t lod = random() % node.lods.size();
    const bool stop = node.isLeaf() || random() % 16 < stop_of_16;
    return stop ? static_cast<int>(lod) : -1;
  });
}

Cut leafCut(const NodeTree& tree) {
  return walk(tree, [](const Node& node) { return node.isLeaf() ? 0 : -1; });
}

bool coversExactlyOnce(const NodeTree& tree, std::span<const CutItem> items) {
  enum State : uint8_t { kOpen, kTaken };
  std::vector<State> states(tree.nodes().size(), kOpen);
  for (const CutItem item : items) {
    if (item.node >= states.size() || item.lod >= tree.node(item.node).lods.size()) return false;
    if (states[item.node] == kTaken) return false;
    states[item.node] = kTaken;
  }
  size_t met = 0;
  std::vector<uint32_t> todo{0};
  while (!todo.empty()) {
    const uint32_t number = todo.back();
    todo.pop_back();
    if (states[number] == kTaken) {
      // Do not descend below an item. An item below another is then not counted, and the comparison at the
      // end fails.
      ++met;
      continue;
    }
    if (tree.node(number).isLeaf()) return false;
    for (uint32_t i = 0; i < tree.childCount(number); ++i) todo.push_back(tree.firstChild(number) + i);
  }
  return met == items.size();
}

}  // namespace lode::store
