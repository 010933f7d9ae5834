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

/// A node of the octree, and the way down from it.
struct KnownNode : Node {
  const KnownNode* children =
      nullptr;                    ///< one for each bit of child_mask, by octant; null: none, or not known
  uint32_t page_below_bytes = 0;  ///< that the page with the children takes in memory, where it is another
  bool is_page_lost = false;      ///< that page: see Hierarchy::lose()
  uint64_t lost_lods = 0;         ///< a bit for each

  bool childrenKnown() const noexcept { return isLeaf() || children != nullptr; }
  std::span<const KnownNode> knownChildren() const noexcept {
    return {children, children == nullptr ? 0 : static_cast<size_t>(std::popcount(child_mask))};
  }

  /// The coarsest LOD that is not lost, and the next finer one than another; nothing where there is none.
  std::optional<uint32_t> coarsestLod() const noexcept {
    return finerLod(static_cast<uint32_t>(lods.size()));
  }
  std::optional<uint32_t> finerLod(uint32_t than) const noexcept {
    while (than-- > 0)
      if (!isLost(than)) return than;
    return std::nullopt;
  }
  bool isLost(uint32_t lod) const noexcept { return (lost_lods >> lod & 1) != 0; }
  /// As far as is known, its children can be shown in its place, or what is below them.
  bool mayGiveWay() const noexcept {
    return !isLeaf() && !is_page_lost && std::ranges::all_of(knownChildren(), [](const KnownNode& child) {
      return child.coarsestLod() || child.mayGiveWay();
    });
  }
};
static_assert(kMaxLods <= 64);

/// Most that a page takes in memory, by the bytes of its blob: each node and each LOD has so many at least.
constexpr uint64_t pageBytesAtMost(uint64_t blob_bytes) noexcept { return 128 + 8 * blob_bytes; }

/// The part of a model's octree that is known, merged from the pages of an untrusted server. Pages that no
/// view uses go when memory is short, and may come again. Not thread safe. Pointers to nodes stay valid until
/// then.
class Hierarchy {
 public:
  /// @param max_nodes  what the model's summary announced; pages that bring more are an error.
  explicit Hierarchy(uint64_t max_nodes) : max_nodes_(max_nodes) {}

  /// Takes the page that holds the root; it stays.
  /// @throws Error kFormat, and the hierarchy is as before: there is a root already, or none in the page.
  void addRootPage(HierarchyPage page);

  /// Takes the page that hangs below `owner`, and checks it against the owner: children as announced, boxes
  /// inside, errors not above.
  /// @throws Error kFormat or kLimit, and the hierarchy is as before.
  void addPage(NodeKey owner, HierarchyPage page);

  /// Starts a new round of use, and forgets pages that are not in use and have none below them, the least
  /// recently used first, until the rest takes no more than so many bytes.
  /// @param owners  of the pages that are in use.
  void use(std::span<const NodeKey> owners, uint64_t budget_bytes);

  /// A blob that cannot be had: LODs and pages that it holds count as lost from now on, on pages that come
  /// later, too.
  void lose(uint32_t blob_number);

  /// @return null if the node is not known.
  const KnownNode* find(NodeKey key) const noexcept;
  const KnownNode* root() const noexcept { return root_ ? root_->nodes.data() : nullptr; }
  size_t size() const noexcept { return size_; }
  /// That it takes in memory, and its first page, which is never forgotten.
  uint64_t bytes() const noexcept { return bytes_; }
  uint64_t rootPageBytes() const noexcept { return root_ ? root_->bytes : 0; }

 private:
  struct Page {
    std::vector<KnownNode> nodes;  // in key order, so that siblings stand together; never moved
    KnownNode* owner = nullptr;    // in the page above
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
  std::set<uint32_t> lost_;  // blobs
  std::unique_ptr<Page> root_;
  std::unordered_map<uint64_t, std::unique_ptr<Page>> pages_;  // by the owner's key, without the root's
};

}  // namespace lode::core
