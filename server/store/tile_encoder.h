#pragma once

#include <cstddef>
#include <vector>

#include "common/image/image.h"

namespace lode::store {

/// Format of an encoded image.
enum class TileCodec {
  kJpeg,      ///< JPEG with full colour resolution, for photographs
  kWebp,      ///< WebP with lossless alpha, for photographs with alpha
  kLossless,  ///< lossless WebP, for drawings of up to 256 colours
};

/// Quality of a store's tiles.
constexpr int kTileQuality = 90;

/// Chooses the format from the image's content. All tiles of an image have the same format, so that their
/// edges do not show. Thread safe.
TileCodec chooseCodec(const Image& image);

/// Encodes a tile. Equal tiles result in equal bytes. @param quality  1 to 100, of lossy formats.
/// @throws Error kInternal. Thread safe.
std::vector<std::byte> encodeTile(const Image& tile, TileCodec codec, int quality = kTileQuality);

}  // namespace lode::store
