#include "client/core/hierarchy.h"

#include <string>
#include <utility>

#include "common/error.h"

namespace lode::core {
namespace {

constexpr uint64_t kEntryBytes = 48;  // of the table beside a node, and what the allocator adds

[[noreturn]] void refuse(NodeKey owner, const char* what) {
  throw Error(ErrorCode::kFormat, "the hierarchy page below node " + std::to_string(owner.value) + " " +
                                      what + ": the store is damaged; run lodestreamd verify on it");
}

}  // namespace

void Hierarchy::addRootPage(HierarchyPage page) {
  if (!nodes_.empty()) refuse(kRootKey, "came twice");
  if (page.nodes.empty() || page.nodes.front().key != kRootKey) refuse(kRootKey, "does not hold the root");
  merge(std::move(page));
}

void Hierarchy::addPage(NodeKey owner_key, HierarchyPage page) {
  const Node* owner = find(owner_key);
  if (!owner || !owner->child_page) refuse(owner_key, "belongs to no known node");
  if (childrenKnown(*owner)) refuse(owner_key, "came twice");
  unsigned children = 0;
  for (const Node& node : page.nodes) {
    if (node.key == owner_key || !owner_key.contains(node.key))
      refuse(owner_key, "holds a node of elsewhere");
    if (node.key.parent() != owner_key) continue;
    children |= 1u << node.key.octant();
    if (!node.box.empty() && !owner->box.contains(node.box)) refuse(owner_key, "leaves its owner's box");
    if (node.rungs.empty()) refuse(owner_key, "holds a node without rungs");
    const Rung& coarsest = node.rungs.back();
    const Rung& finest = owner->rungs.front();
    if (!(coarsest.error_model <= finest.error_model) ||
        !(coarsest.appearance_error_model <= finest.appearance_error_model))
      refuse(owner_key, "has larger errors than its owner");
  }
  if (children != owner->child_mask) refuse(owner_key, "holds other children than its owner announced");
  merge(std::move(page));
}

void Hierarchy::merge(HierarchyPage page) {
  if (nodes_.size() + page.nodes.size() > max_nodes_)
    throw Error(ErrorCode::kLimit,
                "the pages hold more nodes than the " + std::to_string(max_nodes_) +
                    " that the model announced: the store is damaged; run lodestreamd verify on it");
  for (Node& node : page.nodes) {
    node.rungs.shrink_to_fit();
    const uint64_t key = node.key.value;
    bytes_ += kEntryBytes + sizeof(Node) + node.rungs.size() * sizeof(Rung);
    nodes_.emplace(key, std::move(node));
  }
}

const Node* Hierarchy::find(NodeKey key) const noexcept {
  const auto found = nodes_.find(key.value);
  return found == nodes_.end() ? nullptr : &found->second;
}

bool Hierarchy::childrenKnown(const Node& node) const noexcept {
  for (unsigned octant = 0; octant < 8; ++octant)
    if ((node.child_mask >> octant & 1) != 0) return find(node.key.child(octant)) != nullptr;
  return true;
}

}  // namespace lode::core
