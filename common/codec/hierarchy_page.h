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
  BlobRef payload;  ///< no blob where the LOD has no triangles
  uint32_t triangles = 0;
  uint32_t vertices = 0;             ///< that the payload decodes to
  uint32_t locked = 0;               ///< locked vertices among them, by position
  float error_model = 0;             ///< largest deviation from the original surface, model units
  float appearance_error_model = 0;  ///< size of lost detail in colours, normals and pictures, model units

  bool operator==(const Lod&) const = default;
  /// What it is refined on.
  float offModel() const noexcept { return std::max(error_model, appearance_error_model); }
};

struct Node {
  NodeKey key;
  LatticeBox box;  ///< tight box of all LODs and of the children's boxes; empty if there are no triangles
  uint8_t child_mask = 0;  ///< bit o: child(o) exists; 0 for a leaf
  std::vector<Lod> lods;   ///< at least one; errors never fall from finer to coarser
  /// At the end of `lods`, coarser than what the parent is made of: for parts that a view does not see.
  /// Their errors may be above the parent's, those of all others are not. None of the root, nor of leaves.
  uint32_t far_lods = 0;
  BlobRef child_page;  ///< page that holds the children, where they are not in this page

  bool operator==(const Node&) const = default;
  bool isLeaf() const noexcept { return child_mask == 0; }
  /// The LOD that the parent is made of.
  const Lod& sourceLod() const noexcept { return lods[lods.size() - 1 - far_lods]; }
};

/// A subtree in one blob, so that a client learns of a model as it needs to. The root's page holds depths 0
/// to 2; every other page hangs below a node X of even depth >= 2 and holds X's children and grandchildren.
/// Nodes stand in key order. See docs/store-format.md.
struct HierarchyPage {
  std::vector<Node> nodes;
  bool operator==(const HierarchyPage&) const = default;
};

std::vector<std::byte> encodePage(const HierarchyPage& page);

/// Validates everything that can be seen in one page: limits, keys, order, child masks against nodes present,
/// boxes inside parents' boxes, monotone errors (I3).
/// @param owner  the node below which the page hangs; kRootKey with is_root_page for the first page.
/// @throws Error kFormat or kLimit. Thread safe.
HierarchyPage decodePage(std::span<const std::byte> bytes, NodeKey owner, bool is_root_page);

}  // namespace lode
