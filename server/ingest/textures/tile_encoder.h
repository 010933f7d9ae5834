#pragma once

#include <cstddef>
#include <vector>

#include "server/ingest/textures/image_decoder.h"

namespace lode::ingest {

/// How the tiles of a picture are stored.
enum class TileCodec {
  kJpeg,      ///< photographs: quality 90, full colour resolution
  kWebp,      ///< photographs with alpha: quality 90, alpha exact
  kLossless,  ///< drawings of up to 256 colours: WebP without loss
};

/// By a picture's content: all its tiles are stored alike, so that none shows beside the others. Thread safe.
TileCodec chooseCodec(const Image& image);

/// The bytes of a tile's file, the same for the same texels. @throws Error kInternal. Thread safe.
std::vector<std::byte> encodeTile(const Image& tile, TileCodec codec);

}  // namespace lode::ingest
