#include "server/store/node_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/error.h"
#include "common/limits.h"

namespace lode::store {
namespace {

[[noreturn]] void fail(NodeKey key, const std::string& what) {
  throw Error(ErrorCode::kFormat, "node " + describeKey(key) + ": " + what);
}

void checkLod(const Node& node, const Lod& lod, const Lod* finer) {
  if (lod.triangles > kMaxLodTriangles || lod.vertices > kMaxLodVertices)
    throw Error(ErrorCode::kLimit, "node " + describeKey(node.key) + ": an LOD of " +
                                       std::to_string(lod.triangles) + " triangles, the limit is " +
                                       std::to_string(kMaxLodTriangles));
  if ((lod.triangles != 0) != static_cast<bool>(lod.payload))
    fail(node.key, "an LOD has triangles but no payload, or a payload but no triangles");
  if (lod.locked > lod.vertices) fail(node.key, "more locked vertices than vertices");
  if (node.key == kRootKey && lod.locked != 0) fail(node.key, "the root locks vertices");
  if (!std::isfinite(lod.error_model) || lod.error_model < 0 || !std::isfinite(lod.appearance_error_model) ||
      lod.appearance_error_model < 0)
    fail(node.key, "an error is not a finite number");
  if (!finer) return;
  if (lod.triangles > finer->triangles) fail(node.key, "a coarser LOD has more triangles than a finer one");
  if (lod.error_model < finer->error_model || lod.appearance_error_model < finer->appearance_error_model)
    fail(node.key, "a coarser LOD has a smaller error (I3)");
}

void checkNode(const Node& node) {
  if (!node.key.valid()) fail(node.key, "invalid key");
  if (node.lods.empty()) fail(node.key, "no LODs");
  if (node.lods.size() > kMaxLods)
    throw Error(ErrorCode::kLimit,
                "node " + describeKey(node.key) + ": more than " + std::to_string(kMaxLods) + " LODs");
  if (node.isLeaf() && node.key != kRootKey && node.lods.size() != 1)
    fail(node.key, "a leaf with more than one LOD");
  if (node.far_lods >= node.lods.size() || (node.far_lods > 0 && node.key == kRootKey))
    fail(node.key, "too many far LODs");
  const Lod* finer = nullptr;
  for (const Lod& lod : node.lods) {
    checkLod(node, lod, finer);
    finer = &lod;
  }
  const bool flat = node.box.empty() || node.box.min.y > node.box.max.y || node.box.min.z > node.box.max.z;
  if (flat && (node.lods[0].triangles != 0 || !node.box.empty())) fail(node.key, "the box is empty");
  if (!flat && glm::any(glm::greaterThan(node.box.max, glm::uvec3(kMaxLattice))))
    fail(node.key, "the box is outside the lattice");
}

void checkBelowParent(const Node& node, const Node& parent) {
  if ((parent.child_mask >> node.key.octant() & 1) == 0)
    fail(node.key, "its parent's child mask does not include it");
  if (!node.box.empty() && !parent.box.contains(node.box)) fail(node.key, "its box exceeds its parent's box");
  const Lod& coarsest = node.sourceLod();
  const Lod& above = parent.lods.front();
  if (above.error_model < coarsest.error_model ||
      above.appearance_error_model < coarsest.appearance_error_model)
    fail(node.key, "the parent has a smaller error (I3)");
}

}  // namespace

HierarchyTotals checkHierarchy(std::span<const Node> nodes) {
  if (nodes.empty() || nodes[0].key != kRootKey) fail(kRootKey, "the root is missing");
  if (nodes.size() > kMaxNodes)
    throw Error(ErrorCode::kLimit,
                std::to_string(nodes.size()) + " nodes, the limit is " + std::to_string(kMaxNodes));
  HierarchyTotals totals;
  uint64_t announced_children = 0;
  size_t parent = 0;
  for (size_t i = 0; i < nodes.size(); ++i) {
    const Node& node = nodes[i];
    checkNode(node);
    announced_children += static_cast<uint64_t>(std::popcount(node.child_mask));
    if (i > 0) {
      if (node.key <= nodes[i - 1].key) fail(node.key, "out of order");
      while (parent < i && nodes[parent].key < node.key.parent()) ++parent;
      if (nodes[parent].key != node.key.parent()) fail(node.key, "its parent is missing");
      checkBelowParent(node, nodes[parent]);
    }
    for (const Lod& lod : node.lods) {
      totals.stored_triangles += lod.triangles;
      totals.payloads += lod.triangles != 0;
    }
    if (node.isLeaf()) totals.triangles += node.lods.front().triangles;
    totals.depth = std::max(totals.depth, static_cast<uint32_t>(node.key.depth()));
  }
  if (announced_children != nodes.size() - 1)
    fail(kRootKey,
         std::to_string(announced_children - (nodes.size() - 1)) + " children are missing below it");
  return totals;
}

NodeTree::NodeTree(std::span<const Node> nodes) : nodes_(nodes), first_child_(nodes.size()) {
  uint32_t next = 1;
  for (uint32_t i = 0; i < nodes.size(); ++i) {
    first_child_[i] = next;
    next += childCount(i);
  }
}

uint32_t NodeTree::childCount(uint32_t number) const noexcept {
  return static_cast<uint32_t>(std::popcount(nodes_[number].child_mask));
}

std::string describeKey(NodeKey key) {
  if (!key.valid()) return "with key " + std::to_string(key.value);
  std::string text = "root";
  for (int depth = 1; depth <= key.depth(); ++depth)
    text += "/" + std::to_string(key.ancestorAt(depth).octant());
  return text;
}

std::vector<PagePlan> splitIntoPages(std::vector<Node> nodes) {
  std::vector<PagePlan> pages;
  pages.push_back({kRootKey, {}});
  for (const Node& node : nodes)
    if (ownsPage(node)) pages.push_back({node.key, {}});
  for (Node& node : nodes) {
    const NodeKey owner = pageOwner(node.key);
    const auto page = std::lower_bound(pages.begin(), pages.end(), owner,
                                       [](const PagePlan& plan, NodeKey key) { return plan.owner < key; });
    page->page.nodes.push_back(std::move(node));
  }
  return pages;
}

}  // namespace lode::store
