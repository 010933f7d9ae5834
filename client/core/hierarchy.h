#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>

#include "common/hierarchy_page.h"
#include "common/node_key.h"

namespace lode::core {

/// The part of a model's octree that is known so far, merged from the pages of an untrusted server.
/// Not thread safe. Pointers to nodes stay valid as long as the hierarchy.
class Hierarchy {
 public:
  /// @param max_nodes  what the model's summary announced; pages that bring more are an error.
  explicit Hierarchy(uint64_t max_nodes) : max_nodes_(max_nodes) {}

  /// Takes the page that holds the root.
  /// @throws Error kFormat, and the hierarchy is as before: there is a root already, or none in the page.
  void addRootPage(HierarchyPage page);

  /// Takes the page that hangs below `owner`, and checks it against the owner: children as announced, boxes
  /// inside, errors not above.
  /// @throws Error kFormat or kLimit, and the hierarchy is as before.
  void addPage(NodeKey owner, HierarchyPage page);

  /// @return null if the node is not known (yet).
  const Node* find(NodeKey key) const noexcept;
  const Node* root() const noexcept { return find(kRootKey); }
  /// True for leaves too.
  bool childrenKnown(const Node& node) const noexcept;
  size_t size() const noexcept { return nodes_.size(); }
  /// That it takes in memory.
  uint64_t bytes() const noexcept { return bytes_; }

 private:
  void merge(HierarchyPage page);

  uint64_t max_nodes_;
  uint64_t bytes_ = 0;
  std::unordered_map<uint64_t, Node> nodes_;  // by key value; never iterated
};

}  // namespace lode::core
