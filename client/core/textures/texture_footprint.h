#pragma once

#include <cstdint>
#include <vector>

#include "common/codec/texture_set.h"
#include "common/mesh.h"

namespace lode::core {

/// A tile of a texture's level 0 that a mesh uses, and the texel density on the mesh's surface.
///
/// The density favours the regions with the sparsest texels, which would blur first. A triangle's density is
/// the density along the direction with the fewest texels, but at least 1/8 of the density along the
/// direction with the most texels. To combine several triangles, the squared spacings of their texels are
/// averaged, weighted by area; the resulting density is at least 1/8 of the square root of the texels per
/// unit of area.
struct TouchedTile {
  uint32_t texture = 0;
  uint32_t y = 0, x = 0;
  float texels_per_model = 0;  ///< density: level 0 texels per model unit

  bool operator==(const TouchedTile&) const = default;
};

/// A texture of which a mesh uses all level 0 tiles, with one density.
struct WornTexture {
  uint32_t texture = 0;
  float texels_per_model = 0;  ///< density: see TouchedTile

  bool operator==(const WornTexture&) const = default;
};

/// The texture tiles that a mesh uses. No texture is in both lists.
struct TextureFootprint {
  std::vector<TouchedTile> tiles;  ///< sorted by texture, row and column, without duplicates
  std::vector<WornTexture> whole;  ///< sorted by texture, without duplicates

  bool operator==(const TextureFootprint&) const = default;
};

/// Largest number of overlap tests between triangles and tiles per mesh. A hostile or very coarse mesh may
/// need more; each texture that still needs a test then counts as used as a whole.
constexpr uint64_t kMaxTileTests = 1u << 20;

/// Returns the largest number of tiles in a footprint. The limit keeps a footprint from taking much more
/// memory than its mesh. Textures are added in order; if the tiles of one exceed the rest of the limit, it
/// counts as used as a whole.
constexpr uint64_t maxTouchedTiles(uint64_t triangles) noexcept { return 512 + 2 * triangles; }

/// Returns the memory of a footprint.
uint64_t footprintBytes(const TextureFootprint& footprint) noexcept;

/// Computes the footprint of a mesh. A triangle uses the tiles that it overlaps after its texture coordinates
/// are wrapped into 0..1. A triangle whose corners share one texture position uses the tile at that position,
/// but does not affect the density. A triangle uses no tile if its material is unknown or the material's
/// image is missing. Throws only if memory runs out. Thread safe.
/// @param step  lattice step.
TextureFootprint makeFootprint(const Mesh& mesh, const TextureSet& set, double step);

}  // namespace lode::core
