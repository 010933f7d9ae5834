#pragma once

#include <cstdint>
#include <vector>

#include "common/codec/hierarchy_page.h"

/// Export of stores as 3D Tiles 1.1 (OGC 22-025r4, 2023). docs/tiles.md describes the files.
namespace lode::tiles {

/// An LOD of a node that becomes a tile.
struct TileLod {
  uint32_t lod = 0;
  double error_model = 0;  ///< geometricError of the tile, in model units

  bool operator==(const TileLod&) const = default;
};

/// Least ratios of triangles and of errors between consecutive LODs that become tiles. Clients load all tiles
/// on the path from the root, so with smaller ratios they would load almost the same mesh twice.
constexpr double kLeastTriangleRatio = 1.6, kLeastErrorRatio = 1.9;

/// Selects the LODs of a node that become tiles, coarsest first: the node's finest LOD, its coarsest LOD that
/// is not a far LOD, and LODs between them that differ enough. Errors decrease strictly, because some clients
/// always refine a tile whose error is not below its parent's. An error that is not below the previous one
/// becomes (1 - 1e-6) times the previous one. All errors have nine digits. An LOD with error 0 ends the
/// chain, because finer LODs look the same.
/// @param above_model  error of the tile above, larger than 0.
std::vector<TileLod> tileChain(const Node& node, double above_model);

/// Returns true if the children of a node become tiles below the node's chain.
inline bool continuesBelow(const Node& node, const std::vector<TileLod>& chain) {
  return !node.isLeaf() && chain.back().error_model > 0;
}

/// Rounds a number to nine significant digits. Distinct floats stay distinct.
double toNineDigits(double value);

}  // namespace lode::tiles
