#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/codec/blob.h"
#include "common/lattice.h"
#include "common/mesh.h"
#include "common/node_key.h"

namespace lode {

/// One level of detail of a node. LOD 0 is the finest.
struct Lod {
  BlobRef payload;  ///< empty reference if the LOD has no triangles
  uint32_t triangles = 0;
  uint32_t vertices = 0;             ///< vertices of the decoded payload
  uint32_t locked = 0;               ///< number of positions of locked vertices, which several leaves share
  float error_model = 0;             ///< largest distance from the original surface, in model units
  float appearance_error_model = 0;  ///< size of the lost colour, normal and texture detail, in model units

  bool operator==(const Lod&) const = default;
  /// Returns the error that refinement compares with the threshold, in model units.
  float offModel() const noexcept { return std::max(error_model, appearance_error_model); }
};

struct Node {
  NodeKey key;
  LatticeBox box;          ///< smallest box around all LODs and the children's boxes; empty without triangles
  uint8_t child_mask = 0;  ///< bit o is set if child(o) exists; a leaf has no bit set
  std::vector<Lod> lods;   ///< at least one LOD, finest first; errors never decrease
  /// Number of far LODs, which are the last of `lods`. Far LODs are coarser than sourceLod(); clients use
  /// them for nodes outside the view. Only the errors of far LODs may exceed the errors of the parent. The
  /// root and leaves have no far LODs.
  uint32_t far_lods = 0;
  /// Page that contains the children; empty reference if the node's own page contains them.
  BlobRef child_page;

  bool operator==(const Node&) const = default;
  bool isLeaf() const noexcept { return child_mask == 0; }
  /// Returns the LOD from which the parent is built.
  const Lod& sourceLod() const noexcept { return lods[lods.size() - 1 - far_lods]; }
};

/// A subtree of the hierarchy in one blob, so that clients load the hierarchy on demand. The root page
/// contains depths 0 to 2. Every other page belongs to an owner node of even depth >= 2 and contains the
/// owner's children and grandchildren. Nodes are in key order. See docs/store-format.md.
struct HierarchyPage {
  std::vector<Node> nodes;
  bool operator==(const HierarchyPage&) const = default;
};

std::vector<std::byte> encodePage(const HierarchyPage& page);

/// Decodes a page and validates it: limits, keys, order, child masks against the page's nodes, boxes inside
/// parents' boxes, monotone errors (I3 of docs/architecture.md).
/// @param owner  parent of the page's topmost nodes. For the root page, pass kRootKey and set is_root_page.
/// @throws Error kFormat or kLimit. Thread safe.
HierarchyPage decodePage(std::span<const std::byte> bytes, NodeKey owner, bool is_root_page);

}  // namespace lode
