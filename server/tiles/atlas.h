#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "common/image/image.h"
#include "server/tiles/texture_levels.h"

namespace lode::tiles {

/// Longest edge of an image in a tileset, in texels. WebGL 2 guarantees only 2,048, but common devices allow
/// at least 4,096.
constexpr uint32_t kMostImagePx = 4096;
/// Width of a piece's border, in texels. The border repeats the image around the piece, so that filters do
/// not mix neighbouring pieces.
constexpr int kGutterPx = 4;

/// A rectangle of a texture's level that is copied to an atlas.
struct AtlasPiece {
  uint32_t texture = 0, level = 0;
  glm::ivec2 first{0};  ///< first texel, which may lie outside the image
  glm::ivec2 end{0};    ///< texel after the last one
  glm::uvec2 place{0};  ///< first texel in the atlas

  glm::uvec2 size() const noexcept { return glm::uvec2(end - first); }
  uint64_t area() const noexcept { return uint64_t{size().x} * size().y; }
};

/// Merges overlapping pieces of the same level if this does not add texels.
/// @param pieces  replaced by the merged pieces, sorted by texture, level and place.
/// @return for each original piece, the index of the merged piece that contains it.
std::vector<uint32_t> joinPieces(std::vector<AtlasPiece>& pieces);

/// Sets the places of pieces, so that none overlap. @return the size of the atlas. Deterministic.
glm::uvec2 placePieces(std::span<AtlasPiece> pieces);

/// An atlas image. `is_clear` is true if its pieces have transparent texels.
struct Atlas {
  Image image;
  bool is_clear = false;
};

/// Copies pieces to their places. Texels between the pieces and fully transparent texels get the colours
/// around them. @throws Error as TextureLevels::part().
Atlas paintAtlas(std::span<const AtlasPiece> pieces, glm::uvec2 size, TextureLevels& levels);

}  // namespace lode::tiles
