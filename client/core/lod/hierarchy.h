#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/codec/hierarchy_page.h"
#include "common/limits.h"
#include "common/node_key.h"

namespace lode::core {

/// A node of the octree with links to its loaded children.
struct KnownNode : Node {
  /// Array of the children in octant order, one per set bit of child_mask; null if no children are loaded.
  const KnownNode* children = nullptr;
  uint32_t page_below_bytes = 0;  ///< memory of the child page; 0 if no child page is loaded
  bool is_page_lost = false;      ///< true if the child page is lost: see Hierarchy::lose()
  uint64_t lost_lods = 0;         ///< bit i is set if LOD i is lost

  bool childrenKnown() const noexcept { return isLeaf() || children != nullptr; }
  std::span<const KnownNode> knownChildren() const noexcept {
    return {children, children == nullptr ? 0 : static_cast<size_t>(std::popcount(child_mask))};
  }

  /// Returns the coarsest LOD that is not lost, if any.
  std::optional<uint32_t> coarsestLod() const noexcept {
    return finerLod(static_cast<uint32_t>(lods.size()));
  }
  /// Returns the next finer LOD that is not lost, if any.
  std::optional<uint32_t> finerLod(uint32_t than) const noexcept {
    while (than-- > 0)
      if (!isLost(than)) return than;
    return std::nullopt;
  }
  bool isLost(uint32_t lod) const noexcept { return (lost_lods >> lod & 1) != 0; }
  /// Returns true if, as far as the loaded pages tell, descendants can replace this node without a hole: each
  /// child has an LOD that is not lost, or is itself replaceable.
  bool isReplaceable() const noexcept {
    return !isLeaf() && !is_page_lost && std::ranges::all_of(knownChildren(), [](const KnownNode& child) {
      return child.coarsestLod() || child.isReplaceable();
    });
  }
};
static_assert(kMaxLods <= 64);

/// Returns an upper bound for the memory of a decoded page. @param blob_bytes  size of the page's blob.
/// hierarchy.cpp checks the bound for the smallest encoded node and LOD.
constexpr uint64_t pageBytesAtMost(uint64_t blob_bytes) noexcept { return 128 + 8 * blob_bytes; }

/// Largest number of lost blobs that a hierarchy remembers. When it is reached, the hierarchy forgets them
/// all, but LODs that are already marked as lost in loaded pages stay marked.
constexpr size_t kMaxLostBlobs = 65'536;

/// The known part of a model's octree, merged from the pages of an untrusted server. If memory is short,
/// use() evicts pages that no view uses; evicted pages may be loaded again. Pointers to nodes stay valid
/// until their page is evicted. Not thread safe.
class Hierarchy {
 public:
  /// @param max_nodes  number of nodes according to the model's summary; more nodes are an error.
  explicit Hierarchy(uint64_t max_nodes) : max_nodes_(max_nodes) {}

  /// Adds the page that contains the root. This page is never evicted.
  /// @throws Error kFormat if there is already a root or the page contains no root; the hierarchy is
  /// unchanged.
  void addRootPage(HierarchyPage page);

  /// Adds the page that contains the children of `owner`. The children must match the owner's child mask, lie
  /// inside its box and have no larger errors than the owner.
  /// @throws Error kFormat or kLimit; the hierarchy is unchanged.
  void addPage(NodeKey owner, HierarchyPage page);

  /// Starts a new round of use. Evicts unused pages that have no loaded pages below them, least recently used
  /// first, until the rest fits the budget.
  /// @param owners  nodes whose child pages are in use.
  void use(std::span<const NodeKey> owners, uint64_t budget_bytes);

  /// Notes that a blob cannot be loaded. The LODs or the child page in this blob count as lost, even if the
  /// node that refers to them is added later.
  void lose(uint32_t blob_number);

  /// @return null if the node is not loaded.
  const KnownNode* find(NodeKey key) const noexcept;
  const KnownNode* root() const noexcept { return root_ ? root_->nodes.data() : nullptr; }
  size_t size() const noexcept { return size_; }
  /// Returns the memory of all loaded pages.
  uint64_t bytes() const noexcept { return bytes_; }
  uint64_t rootPageBytes() const noexcept { return root_ ? root_->bytes : 0; }

 private:
  struct Page {
    std::vector<KnownNode> nodes;  // sorted by key, so siblings are consecutive; never reallocated
    KnownNode* owner = nullptr;    // parent of the page's topmost nodes; belongs to the page above
    uint32_t bytes = 0;
    uint64_t used_round = 0;
    Page* above = nullptr;
    uint32_t pages_below = 0;
  };
  std::unique_ptr<Page> link(HierarchyPage page, size_t first_level) const;
  void markLost(Page& page) const;
  Page& pageOf(NodeKey key);
  void forget(uint64_t owner);

  uint64_t max_nodes_;
  size_t size_ = 0;
  uint64_t bytes_ = 0;
  uint64_t round_ = 1;
  std::set<uint32_t> lost_;  // numbers of lost blobs
  std::unique_ptr<Page> root_;
  // All pages except the root page, keyed by the owner's NodeKey::value.
  std::unordered_map<uint64_t, std::unique_ptr<Page>> pages_;
};

}  // namespace lode::core
