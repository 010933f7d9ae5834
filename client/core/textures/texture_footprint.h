#pragma once

#include <cstdint>
#include <vector>

#include "common/codec/texture_set.h"
#include "common/mesh.h"

namespace lode::core {

/// A tile of a texture's level 0 that a mesh wears, and how closely its texels lie on the surface there.
///
/// It is counted with a view to where they lie farthest apart, which would be blurred first: on each triangle
/// along the direction with the fewest, but not below an eighth of the most; over the triangles by the mean
/// of the squared distances between texels, which leans towards the greater, but not below an eighth of what
/// areas say.
struct TouchedTile {
  uint32_t texture = 0;
  uint32_t y = 0, x = 0;
  float texels_per_model = 0;  ///< level 0 texels a model unit

  bool operator==(const TouchedTile&) const = default;
};

/// A texture that a mesh wears as a whole: all tiles of level 0, as closely everywhere.
struct WornTexture {
  uint32_t texture = 0;
  float texels_per_model = 0;  ///< as that of a tile

  bool operator==(const WornTexture&) const = default;
};

/// What a mesh needs of the textures. No texture is in both lists.
struct TextureFootprint {
  std::vector<TouchedTile> tiles;  ///< by texture, row and column, each once
  std::vector<WornTexture> whole;  ///< by texture, each once

  bool operator==(const TextureFootprint&) const = default;
};

/// Tests of a triangle against a tile that one mesh is worth. A mesh that would take more, as only hostile
/// or very coarse ones do, is taken to touch all of the textures that it has not finished.
constexpr uint64_t kMaxTileTests = 1u << 20;

/// Tiles that a footprint names at most, so that it takes no more memory than about that of its mesh: of
/// textures that touch more than what is left of it, in their order, the whole is said to be touched.
constexpr uint64_t maxTouchedTiles(uint64_t triangles) noexcept { return 512 + 2 * triangles; }

/// Bytes that a footprint takes in memory.
uint64_t footprintBytes(const TextureFootprint& footprint) noexcept;

/// The footprint of a mesh. A triangle touches the tiles that it overlaps once the coordinates outside 0..1
/// have been brought back by repeating the image. Triangles all at one place of the image touch its tile
/// too, but count for nothing else, if there are others. Vertices of a material that the set lacks, or whose
/// image is missing, touch nothing. Never throws but for want of memory; thread safe.
/// @param step  of the lattice.
TextureFootprint makeFootprint(const Mesh& mesh, const TextureSet& set, double step);

}  // namespace lode::core
