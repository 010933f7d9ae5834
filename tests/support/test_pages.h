#pragma once

#include <cstdint>
#include <random>

#include "common/codec/hierarchy_page.h"
#include "common/limits.h"

/// Hierarchy pages made from a seed, for the tests of all modules.
namespace lode::test {

struct PageOptions {
  NodeKey owner = kRootKey;
  bool is_root_page = true;
  uint32_t seed = 1;
  unsigned children = 8;      ///< number of children of each inner node, 0..8
  unsigned lods = 2;          ///< number of LODs of each node, without far LODs
  unsigned far_lods = 0;      ///< number of far LODs of inner nodes below the root
  bool deeper_pages = false;  ///< true if nodes of the deepest level have children in further pages
};

/// Makes a page that decodePage() accepts. Digests and counts are random, boxes are nested, and errors grow
/// towards the root.
inline HierarchyPage makePage(const PageOptions& options) {
  std::mt19937 random(options.seed);
  HierarchyPage page;
  const auto blob = [&](uint32_t most_bytes) {
    BlobRef ref{
        1 + static_cast<uint32_t>(random() % 100000), 1 + static_cast<uint32_t>(random() % most_bytes), {}};
    for (std::byte& byte : ref.digest.bytes) byte = static_cast<std::byte>(random() & 255);
    return ref;
  };
  const auto node = [&](NodeKey key, int level) {
    Node result;
    result.key = key;
    const unsigned inset = static_cast<unsigned>(level) * 1000;
    result.box = {glm::uvec3(1000 + inset), glm::uvec3(kMaxLattice - inset)};
    const bool inner = level < 2 || (options.deeper_pages && key.depth() < kMaxDepth);
    result.child_mask = static_cast<uint8_t>(inner ? (1u << options.children) - 1 : 0);
    if (level == 2 && !result.isLeaf()) result.child_page = blob(kMaxPageBytes);
    const bool has_spare = !result.isLeaf() && key != kRootKey;
    result.far_lods = has_spare ? options.far_lods : 0;
    float error = static_cast<float>(100 >> level * 2);
    for (unsigned i = 0; i < options.lods + result.far_lods; ++i) {
      if (i == options.lods) error *= 10;  // the errors of far LODs exceed the parent's
      Lod lod{blob(60000), 1000 + static_cast<uint32_t>(random() % 15000), 0, 0, error, error / 2};
      lod.vertices = lod.triangles / 2 + 50;
      lod.locked = lod.vertices / 20;
      result.lods.push_back(lod);
      error *= 1 + 0.1f / static_cast<float>(options.lods);
    }
    return result;
  };
  if (options.is_root_page) page.nodes.push_back(node(options.owner, 0));
  if (options.is_root_page && options.children == 0) return page;
  for (unsigned o = 0; o < options.children; ++o) page.nodes.push_back(node(options.owner.child(o), 1));
  for (unsigned o = 0; o < options.children; ++o)
    for (unsigned p = 0; p < options.children; ++p)
      page.nodes.push_back(node(options.owner.child(o).child(p), 2));
  return page;
}

}  // namespace lode::test
