#pragma once

#include <cstddef>
#include <vector>

namespace lode::ingest {

constexpr size_t kRootTriangles = 512;  ///< to which the root's rungs go down

/// Triangle counts of the reduced rungs of a node, falling: steps of 2, at depths 0 to 2 of the square root
/// of 2, until at most max(triangles_per_node, 4 * locked); at the root, which locks nothing, until
/// kRootTriangles. At least one, but for a root that is small enough already.
std::vector<size_t> rungTargets(size_t triangles, size_t locked, int depth, size_t triangles_per_node);

}  // namespace lode::ingest
