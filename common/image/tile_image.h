#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace lode {

/// A decoded tile of a texture, with rows from the top and sRGB texels with alpha.
struct TileImage {
  glm::uvec2 size{0};
  std::vector<glm::u8vec4> texels;
  /// Coarser levels, each half as wide and high as the previous one; decodeTile() leaves the list empty.
  std::vector<TileImage> coarser;

  bool operator==(const TileImage&) const = default;
};

/// Returns true if the header of a tile's file says that texels may be transparent.
bool tileMayBeClear(std::span<const std::byte> file) noexcept;

/// Decodes a tile from an untrusted source. The first bytes of the file tell whether the tile is JPEG or
/// WebP.
/// @param size  size of the tile with gutters, at most kTilePx along each axis. This size alone determines
///              the memory used, because decodeTile() refuses a file of another size.
/// @throws Error kFormat or kLimit if the file is neither JPEG nor WebP, has another size, is damaged or
/// animated, or has too many scans. Thread safe.
TileImage decodeTile(std::span<const std::byte> file, glm::uvec2 size);

}  // namespace lode
