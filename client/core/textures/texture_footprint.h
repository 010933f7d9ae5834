#pragma once

#include <cstdint>
#include <vector>

#include "common/codec/texture_set.h"
#include "common/mesh.h"

namespace lode::core {

/// A tile of a texture's level 0 that a mesh uses, and the texel density on the surface there.
///
/// The density favours the places with the sparsest texels, which would blur first. Per triangle it is the
/// density along the direction with the fewest texels, at least 1/8 of that with the most. Over the triangles
/// it follows from the area-weighted mean of the squared texel distances, and is at least 1/8 of the density
/// computed from areas.
struct TouchedTile {
  uint32_t texture = 0;
  uint32_t y = 0, x = 0;
  float texels_per_model = 0;  ///< level 0 texels per model unit

  bool operator==(const TouchedTile&) const = default;
};

/// A texture of which a mesh uses all level 0 tiles, with one density.
struct WornTexture {
  uint32_t texture = 0;
  float texels_per_model = 0;  ///< see TouchedTile

  bool operator==(const WornTexture&) const = default;
};

/// The texture tiles that a mesh uses. No texture is in both lists.
struct TextureFootprint {
  std::vector<TouchedTile> tiles;  ///< by texture, row and column, each once
  std::vector<WornTexture> whole;  ///< by texture, each once

  bool operator==(const TextureFootprint&) const = default;
};

/// Largest number of triangle-tile tests per mesh. A mesh that needs more, hostile or very coarse, counts as
/// using its remaining textures as a whole.
constexpr uint64_t kMaxTileTests = 1u << 20;

/// Largest number of tiles in a footprint, so that it takes about the memory of its mesh at most. Textures
/// that exceed the remaining number, in their order, count as used as a whole.
constexpr uint64_t maxTouchedTiles(uint64_t triangles) noexcept { return 512 + 2 * triangles; }

/// Memory of a footprint.
uint64_t footprintBytes(const TextureFootprint& footprint) noexcept;

/// Computes the footprint of a mesh. A triangle uses the tiles that it overlaps after its texture coordinates
/// are wrapped into 0..1. A triangle whose corners share one texture position uses that tile, but does not
/// count towards the density. Vertices of an unknown material or with a missing image use nothing. Throws
/// only if memory runs out. Thread safe.
/// @param step  lattice step.
TextureFootprint makeFootprint(const Mesh& mesh, const TextureSet& set, double step);

}  // namespace lode::core
