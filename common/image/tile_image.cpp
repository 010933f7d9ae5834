#include "common/image/tile_image.h"

#include <string>

#include <webp/decode.h>

#include "common/codec/texture_set.h"
#include "common/error.h"
#include "common/image/jpeg_decoder.h"

namespace lode {
namespace {

[[noreturn]] void refuseTile(const std::string& why) {
  throw Error(ErrorCode::kFormat, "damaged texture tile: " + why + "; fetch it again or rebuild the store");
}

[[noreturn]] void refuseSize(glm::uvec2 size) {
  refuseTile("it is " + std::to_string(size.x) + "x" + std::to_string(size.y) + " texels");
}

void decodeJpeg(std::span<const std::byte> file, TileImage& image) {
  JpegDecoder decoder(file, true);
  if (!decoder.readHeader()) refuseTile(std::string("libjpeg says: ") + decoder.failure());
  if (decoder.size() != image.size) refuseSize(decoder.size());
  if (!decoder.readTexels(image.texels)) refuseTile(std::string("libjpeg says: ") + decoder.failure());
}

void decodeWebp(std::span<const std::byte> file, TileImage& image) {
  const auto* const bytes = reinterpret_cast<const uint8_t*>(file.data());
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(bytes, file.size(), &features) != VP8_STATUS_OK) refuseTile("it is no WebP");
  if (features.has_animation != 0) refuseTile("it is animated");
  if (const glm::uvec2 size(features.width, features.height); size != image.size) refuseSize(size);
  const size_t room = image.texels.size() * sizeof(glm::u8vec4);
  if (WebPDecodeRGBAInto(bytes, file.size(), reinterpret_cast<uint8_t*>(image.texels.data()), room,
                         static_cast<int>(image.size.x * sizeof(glm::u8vec4))) == nullptr) {
    refuseTile("libwebp cannot decode it");
  }
}

}  // namespace

bool tileMayBeClear(std::span<const std::byte> file) noexcept {
  WebPBitstreamFeatures features;
  const auto* const bytes = reinterpret_cast<const uint8_t*>(file.data());
  return tileKind(file) == TileKind::kWebp &&
         WebPGetFeatures(bytes, file.size(), &features) == VP8_STATUS_OK && features.has_alpha != 0;
}

TileImage decodeTile(std::span<const std::byte> file, glm::uvec2 size) {
  if (size.x == 0 || size.y == 0 || size.x > kTilePx || size.y > kTilePx || file.size() > kMaxTileBytes) {
    throw Error(ErrorCode::kLimit, "a texture tile of " + std::to_string(size.x) + "x" +
                                       std::to_string(size.y) + " texels in " + std::to_string(file.size()) +
                                       " bytes is outside the limits");
  }
  const std::optional<TileKind> kind = tileKind(file);
  if (!kind) refuseTile("it is neither JPEG nor WebP");
  TileImage image{size, std::vector<glm::u8vec4>(size_t{size.x} * size.y), {}};
  if (*kind == TileKind::kJpeg) {
    decodeJpeg(file, image);
  } else {
    decodeWebp(file, image);
  }
  return image;
}

}  // namespace lode
