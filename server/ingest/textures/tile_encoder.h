#pragma once

#include <cstddef>
#include <vector>

#include "server/ingest/textures/image_decoder.h"

namespace lode::ingest {

/// Format of an image's tiles.
enum class TileCodec {
  kJpeg,      ///< photographs: quality 90, full colour resolution
  kWebp,      ///< photographs with alpha: quality 90, alpha exact
  kLossless,  ///< drawings of up to 256 colours: lossless WebP
};

/// Chooses the format by the image's content. All tiles of an image use one, so that no tile stands out.
/// Thread safe.
TileCodec chooseCodec(const Image& image);

/// Encodes a tile; equal texels give equal bytes. @throws Error kInternal. Thread safe.
std::vector<std::byte> encodeTile(const Image& tile, TileCodec codec);

}  // namespace lode::ingest
