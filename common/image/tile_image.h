#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace lode {

/// A decoded tile of a texture: its texels by rows from the top, sRGB with alpha.
struct TileImage {
  glm::uvec2 size{0};
  std::vector<glm::u8vec4> texels;
  std::vector<TileImage> coarser;  ///< levels below this one, halved from it; empty as decoded

  bool operator==(const TileImage&) const = default;
};

/// Whether a tile's file may have texels that are not opaque, as its header says; nothing else is looked at.
bool tileMayBeClear(std::span<const std::byte> file) noexcept;

/// Decodes the file of a tile from an untrusted source: JPEG or WebP, told apart by their first bytes.
/// @param size  that the tile must have, gutters included; at most kTilePx each way: the memory taken
///              follows from it alone, and a file that announces another size is refused.
/// @throws Error kFormat or kLimit: no JPEG or WebP, another size, damaged, animated, or made to take long.
/// Thread safe.
TileImage decodeTile(std::span<const std::byte> file, glm::uvec2 size);

}  // namespace lode
