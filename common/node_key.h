#pragma once

#include <bit>
#include <compare>
#include <cstdint>

namespace lode {

constexpr int kMaxDepth = 20;  ///< largest depth of a node; the root has depth 0

/// Locational code of an octree cell: a leading 1, then 3 bits per level (x is bit 0, y bit 1, z bit 2).
/// Ordering keys by value puts coarse nodes before fine nodes and keeps siblings together.
/// Source: Gargantini, An Effective Way to Represent Quadtrees, 1982.
struct NodeKey {
  uint64_t value = 1;

  friend constexpr auto operator<=>(NodeKey, NodeKey) = default;

  constexpr bool valid() const noexcept {
    return value != 0 && (std::bit_width(value) - 1) % 3 == 0 && depth() <= kMaxDepth;
  }
  constexpr int depth() const noexcept { return (static_cast<int>(std::bit_width(value)) - 1) / 3; }
  constexpr NodeKey parent() const noexcept { return {value >> 3}; }
  constexpr NodeKey child(unsigned octant) const noexcept { return {value << 3 | octant}; }
  constexpr unsigned octant() const noexcept { return static_cast<unsigned>(value & 7); }
  /// Returns the node's ancestor at a depth from 0 to depth(); the ancestor at depth() is the node itself.
  constexpr NodeKey ancestorAt(int at_depth) const noexcept { return {value >> 3 * (depth() - at_depth)}; }
  /// Returns true for the node itself and its descendants.
  constexpr bool contains(NodeKey other) const noexcept {
    return other.depth() >= depth() && other.ancestorAt(depth()) == *this;
  }
};

constexpr NodeKey kRootKey{1};

/// Returns the lowest common ancestor.
constexpr NodeKey commonAncestor(NodeKey a, NodeKey b) noexcept {
  if (a.depth() > b.depth()) a = a.ancestorAt(b.depth());
  if (b.depth() > a.depth()) b = b.ancestorAt(a.depth());
  while (a != b) {
    a = a.parent();
    b = b.parent();
  }
  return a;
}

}  // namespace lode
