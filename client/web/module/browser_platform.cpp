#include <algorithm>
#include <array>

#include "client/web/core/sha256.h"
#include "common/codec/blob.h"
#include "common/error.h"
#include "common/image/tile_image.h"

/// Implements without OpenSSL, libjpeg and libwebp the functions that use these libraries in other programs.
/// Only the WebAssembly module contains this file.
namespace lode {

Digest digestOf(std::span<const std::byte> blob) {
  const std::array<std::byte, 32> digest = web::sha256(blob);
  Digest name;
  std::copy_n(digest.begin(), name.bytes.size(), name.bytes.begin());
  return name;
}

TileImage decodeTile(std::span<const std::byte> /*file*/, glm::uvec2 /*size*/) {
  throw Error(ErrorCode::kInternal, "the browser decodes images: call decodeImage()");
}

}  // namespace lode
