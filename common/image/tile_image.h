#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace lode {

/// A decoded tile of a texture: rows from the top, sRGB with alpha.
struct TileImage {
  glm::uvec2 size{0};
  std::vector<glm::u8vec4> texels;
  std::vector<TileImage> coarser;  ///< coarser levels, made by halving; decodeTile() leaves them empty

  bool operator==(const TileImage&) const = default;
};

/// Returns true if the header of a tile's file allows texels that are not opaque.
bool tileMayBeClear(std::span<const std::byte> file) noexcept;

/// Decodes a tile from an untrusted source: JPEG or WebP by its first bytes.
/// @param size  size of the tile with gutters, at most kTilePx each way. It alone determines the memory used:
///              decodeTile() refuses a file of another size.
/// @throws Error kFormat or kLimit if the file is neither JPEG nor WebP, has another size, is damaged or
/// animated, or has too many scans. Thread safe.
TileImage decodeTile(std::span<const std::byte> file, glm::uvec2 size);

}  // namespace lode
