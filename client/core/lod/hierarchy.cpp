#include "client/core/lod/hierarchy.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/error.h"

namespace lode::core {
namespace {

constexpr uint64_t kAllocationBytes = 16;  // allocator overhead of a node's LODs
constexpr uint64_t kPageBytes = 128;       // memory of a page and its table entry, without nodes
constexpr uint64_t kLeastNodeBytes = 20, kLeastLodBytes = 9;  // smallest encoded sizes: docs/store-format.md
static_assert(sizeof(KnownNode) + kAllocationBytes + kPageBytes <= pageBytesAtMost(kLeastNodeBytes));
static_assert(sizeof(Lod) + kPageBytes <= pageBytesAtMost(kLeastLodBytes));

[[noreturn]] void refuse(NodeKey owner, const char* what) {
  throw Error(ErrorCode::kFormat, "the hierarchy page below node " + std::to_string(owner.value) + " " +
                                      what + ": the store is damaged; run lodestreamd verify on it");
}

unsigned childCount(const Node& node) { return static_cast<unsigned>(std::popcount(node.child_mask)); }

}  // namespace

void Hierarchy::addRootPage(HierarchyPage page) {
  if (root_) refuse(kRootKey, "was received twice");
  if (page.nodes.empty() || page.nodes.front().key != kRootKey) refuse(kRootKey, "does not contain the root");
  root_ = link(std::move(page), 1);
  markLost(*root_);
  size_ = root_->nodes.size();
  bytes_ = root_->bytes;
}

void Hierarchy::addPage(NodeKey owner_key, HierarchyPage page) {
  auto* const owner = const_cast<KnownNode*>(find(owner_key));  // safe, because this object owns the node
  if (!owner || !owner->child_page) refuse(owner_key, "does not belong to a known node");
  if (owner->childrenKnown()) refuse(owner_key, "was received twice");
  unsigned children = 0;
  for (const Node& node : page.nodes) {
    if (node.key == owner_key || !owner_key.contains(node.key))
      refuse(owner_key, "contains a node outside its subtree");
    if (node.key.parent() != owner_key) continue;
    children |= 1u << node.key.octant();
    if (!node.box.empty() && !owner->box.contains(node.box))
      refuse(owner_key, "exceeds the box of its owner");
    if (node.lods.empty()) refuse(owner_key, "holds a node without LODs");
    const Lod& coarsest = node.sourceLod();
    const Lod& finest = owner->lods.front();
    if (!(coarsest.error_model <= finest.error_model) ||
        !(coarsest.appearance_error_model <= finest.appearance_error_model))
      refuse(owner_key, "has larger errors than its owner");
  }
  if (children != owner->child_mask)
    refuse(owner_key, "does not match the children that its owner announced");
  std::unique_ptr<Page> linked = link(std::move(page), childCount(*owner));
  markLost(*linked);
  linked->owner = owner;
  linked->used_round = round_;
  linked->above = &pageOf(owner_key);
  ++linked->above->pages_below;
  owner->children = linked->nodes.data();
  owner->page_below_bytes = linked->bytes;
  size_ += linked->nodes.size();
  bytes_ += linked->bytes;
  pages_.emplace(owner_key.value, std::move(linked));
}

/// Links each node to its children, which are consecutive in key order.
/// @param first_level  number of leading nodes whose parents are not in the page.
std::unique_ptr<Hierarchy::Page> Hierarchy::link(HierarchyPage page, size_t first_level) const {
  if (size_ + page.nodes.size() > max_nodes_)
    throw Error(ErrorCode::kLimit,
                "the pages hold more nodes than the " + std::to_string(max_nodes_) +
                    " that the model announced: the store is damaged; run lodestreamd verify on it");
  auto linked = std::make_unique<Page>();
  linked->nodes.reserve(page.nodes.size());
  uint64_t bytes = kPageBytes;
  for (Node& node : page.nodes) {
    node.lods.shrink_to_fit();
    bytes += sizeof(KnownNode) + kAllocationBytes + node.lods.size() * sizeof(Lod);
    linked->nodes.push_back({std::move(node)});
  }
  linked->bytes = static_cast<uint32_t>(bytes);
  size_t next = first_level;
  for (KnownNode& node : linked->nodes) {
    if (node.isLeaf() || node.child_page) continue;
    if (next + childCount(node) > linked->nodes.size() || linked->nodes[next].key.parent() != node.key)
      refuse(node.key, "is missing a child");
    node.children = &linked->nodes[next];
    next += childCount(node);
  }
  return linked;
}

void Hierarchy::lose(uint32_t blob_number) {
  if (lost_.size() >= kMaxLostBlobs) lost_.clear();
  lost_.insert(blob_number);
  if (root_) markLost(*root_);
  for (const auto& [owner, page] : pages_) markLost(*page);
}

void Hierarchy::markLost(Page& page) const {
  if (lost_.empty()) return;
  for (KnownNode& node : page.nodes) {
    node.is_page_lost = node.child_page && lost_.contains(node.child_page.number);
    for (uint32_t lod = 0; lod < node.lods.size(); ++lod)
      if (node.lods[lod].triangles != 0 && lost_.contains(node.lods[lod].payload.number))
        node.lost_lods |= uint64_t{1} << lod;
  }
}

void Hierarchy::use(std::span<const NodeKey> owners, uint64_t budget_bytes) {
  ++round_;
  for (const NodeKey owner : owners)
    if (const auto page = pages_.find(owner.value); page != pages_.end()) page->second->used_round = round_;
  if (bytes_ <= budget_bytes) return;

  struct Spare {
    uint64_t used_round = 0, owner = 0;
  };
  std::vector<Spare> spare;
  for (const auto& [owner, page] : pages_)
    if (page->used_round != round_) spare.push_back({page->used_round, owner});
  // Among pages last used in the same round, evict deeper pages first, so that one call can evict a whole
  // branch.
  std::sort(spare.begin(), spare.end(), [](const Spare& a, const Spare& b) {
    return a.used_round != b.used_round ? a.used_round < b.used_round : a.owner > b.owner;
  });
  for (const Spare& next : spare) {
    if (bytes_ <= budget_bytes) return;
    if (pages_.find(next.owner)->second->pages_below == 0) forget(next.owner);
  }
}

Hierarchy::Page& Hierarchy::pageOf(NodeKey key) {
  for (; key != kRootKey; key = key.parent())
    if (const auto page = pages_.find(key.parent().value); page != pages_.end()) return *page->second;
  return *root_;
}

void Hierarchy::forget(uint64_t owner) {
  const auto found = pages_.find(owner);
  const Page& page = *found->second;
  page.owner->children = nullptr;
  page.owner->page_below_bytes = 0;
  --page.above->pages_below;
  size_ -= page.nodes.size();
  bytes_ -= page.bytes;
  pages_.erase(found);
}

const KnownNode* Hierarchy::find(NodeKey key) const noexcept {
  const KnownNode* node = root();
  for (int depth = 1; node != nullptr && depth <= key.depth(); ++depth) {
    const unsigned octant = key.ancestorAt(depth).octant();
    if (node->children == nullptr || (node->child_mask >> octant & 1) == 0) return nullptr;
    node = node->children + std::popcount(node->child_mask & ((1u << octant) - 1));
  }
  return node;
}

}  // namespace lode::core
