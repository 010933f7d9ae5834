#include <algorithm>
#include <cstring>
#include <string_view>

#include <png.h>
#include <webp/decode.h>

#include "common/error.h"
#include "common/jpeg_decoder.h"
#include "common/texture_set.h"
#include "server/ingest/image.h"

namespace lode::ingest {
namespace {

constexpr uint64_t kTexelBytes = sizeof(glm::u8vec4);
/// Of a texel beside the picture itself: a JPEG's coefficients; the next level, or a decoder's rows.
constexpr uint64_t kJpegTexelBytes = 6, kOtherTexelBytes = 2;

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorCode::kInput, what); }

/// What a picture's memory may cost; checked before any of it is taken.
class Budget {
 public:
  explicit Budget(uint64_t memory_bytes) : memory_bytes_(memory_bytes) {}

  Image makeImage(uint64_t width, uint64_t height, uint64_t beside) const {
    if (width == 0 || height == 0) refuse("has no pixels");
    const std::string size = std::to_string(width) + " x " + std::to_string(height) + " pixels";
    if (std::max(width, height) > kMaxTextureEdgePx)
      refuse("has " + size + ", the limit is " + std::to_string(kMaxTextureEdgePx) + " each way");
    const uint64_t needed = width * height * (kTexelBytes + beside);
    if (needed > memory_bytes_)
      throw Error(ErrorCode::kLimit, "has " + size + ", which take " + std::to_string(needed) +
                                         " bytes of memory; raise --memory or scale it down");
    Image image;
    image.size = {width, height};
    image.texels.resize(width * height);
    return image;
  }

 private:
  const uint64_t memory_bytes_;
};

Image decodePng(std::span<const std::byte> file, const Budget& budget) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&png, file.data(), file.size()) == 0)
    refuse(std::string("is a damaged PNG: ") + png.message);
  Image image;
  try {
    image = budget.makeImage(png.width, png.height, kOtherTexelBytes);
  } catch (...) {
    png_image_free(&png);
    throw;
  }
  png.format = PNG_FORMAT_RGBA;
  if (png_image_finish_read(&png, nullptr, image.texels.data(), 0, nullptr) == 0)
    refuse(std::string("is a damaged PNG: ") + png.message);
  return image;
}

Image decodeJpeg(std::span<const std::byte> file, const Budget& budget, std::string& damage) {
  JpegDecoder decoder(file, false);
  if (!decoder.readHeader()) refuse(std::string("is a damaged JPEG: ") + decoder.failure());
  Image image = budget.makeImage(decoder.size().x, decoder.size().y, kJpegTexelBytes);
  if (!decoder.readTexels(image.texels)) refuse(std::string("is a damaged JPEG: ") + decoder.failure());
  damage = decoder.warning();
  return image;
}

Image decodeWebp(std::span<const std::byte> file, const Budget& budget) {
  const auto* const bytes = reinterpret_cast<const uint8_t*>(file.data());
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(bytes, file.size(), &features) != VP8_STATUS_OK) refuse("is a damaged WebP");
  if (features.has_animation != 0) refuse("is an animated WebP");
  const auto width = static_cast<uint64_t>(features.width), height = static_cast<uint64_t>(features.height);
  Image image = budget.makeImage(width, height, kTexelBytes + kOtherTexelBytes);
  if (WebPDecodeRGBAInto(bytes, file.size(), reinterpret_cast<uint8_t*>(image.texels.data()),
                         image.texels.size() * kTexelBytes, static_cast<int>(width * kTexelBytes)) == nullptr)
    refuse("is a damaged WebP");
  return image;
}

}  // namespace

Image decodeImage(std::span<const std::byte> file, uint64_t memory_bytes, std::string& damage) {
  constexpr std::string_view kPngMagic = "\x89PNG\r\n\x1a\n";
  const Budget budget(memory_bytes);
  damage.clear();
  if (file.size() >= kPngMagic.size() && std::memcmp(file.data(), kPngMagic.data(), kPngMagic.size()) == 0)
    return decodePng(file, budget);
  if (const auto kind = tileKind(file))
    return *kind == TileKind::kJpeg ? decodeJpeg(file, budget, damage) : decodeWebp(file, budget);
  refuse("is no JPEG, PNG or WebP picture: convert it to one");
}

}  // namespace lode::ingest
