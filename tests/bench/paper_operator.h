#pragma once

#include <cstdint>
#include <functional>

#include "tests/bench/bench_models.h"

namespace lode::bench {

/// The operator of the paper of 2005: in an octree whose leaves hold at most `leaf_triangles`, from the
/// leaves up, all interior vertices of a node become one, at the optimum of their summed quadrics, and those
/// that it shares with other nodes stay until their common ancestor. It is cluster() with one cell a node. (A
/// store's LODs stop at a node's budget; these do not.)
/// @param visit  called for the cut at each depth, from the leaves' up: every node at that depth, simplified,
///               and the leaves above it.
void simplifyAsThePaper(const FileNode& model, uint32_t leaf_triangles,
                        const std::function<void(int depth, test::TriangleSoup&& lattice_soup)>& visit);

}  // namespace lode::bench
