#pragma once

#include <cstddef>
#include <vector>

#include "common/image/image.h"

namespace lode::store {

/// Format of an encoded image.
enum class TileCodec {
  kJpeg,      ///< JPEG of quality 90 with full colour resolution, for photographs
  kWebp,      ///< WebP of quality 90 with lossless alpha, for photographs with alpha
  kLossless,  ///< lossless WebP, for drawings of up to 256 colours
};

/// Chooses the format from the image's content. All tiles of an image have the same format, so that their
/// edges do not show. Thread safe.
TileCodec chooseCodec(const Image& image);

/// Encodes a tile. Equal tiles result in equal bytes. @throws Error kInternal. Thread safe.
std::vector<std::byte> encodeTile(const Image& tile, TileCodec codec);

}  // namespace lode::store
