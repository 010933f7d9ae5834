#include "server/ingest/textures/image_decoder.h"

#include <algorithm>
#include <cstring>
#include <string_view>

#include <png.h>
#include <webp/decode.h>

#include "common/byte_size.h"
#include "common/codec/texture_set.h"
#include "common/error.h"
#include "common/image/jpeg_decoder.h"

namespace lode::ingest {
namespace {

constexpr uint64_t kTexelBytes = sizeof(glm::u8vec4);
/// Memory per texel in addition to the image, for the next coarser level or the decoder's rows.
constexpr uint64_t kUsualTexelBytes = 2;
/// Additional memory per texel for a progressive JPEG: the decoder keeps the coefficients of the whole image.
constexpr uint64_t kCoefficientBytes = 6;
constexpr uint64_t kJpegShrinking = 8;  ///< JpegDecoder::shrink() divides width and height by this
/// A progressive JPEG keeps coefficients for a width and height rounded up to a multiple of this size.
constexpr uint64_t kJpegBlockPx = 32;
/// Memory of the tables for decoding lossless WebP or lossless alpha. Files of the reference encoder need no
/// more, but a crafted file can.
constexpr uint64_t kWebpTableBytes = 1u << 20;

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorCode::kInput, what); }

/// @param decoder_bytes  memory per texel for the decoder.
ImageHeader headerOf(uint64_t width, uint64_t height, uint64_t decoder_bytes) {
  if (width == 0 || height == 0) refuse("has no pixels");
  if (std::max(width, height) > kMaxTextureEdgePx)
    refuse("has " + std::to_string(width) + " x " + std::to_string(height) + " pixels; the limit is " +
           std::to_string(kMaxTextureEdgePx) + " per side; scale it down");
  return {width, height, width * height * (kTexelBytes + kUsualTexelBytes + decoder_bytes)};
}

ImageHeader readPngHeader(std::span<const std::byte> file) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&png, file.data(), file.size()) == 0)
    refuse(std::string("is a damaged PNG: ") + png.message);
  png_image_free(&png);
  return headerOf(png.width, png.height, 0);
}

void decodePng(std::span<const std::byte> file, Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&png, file.data(), file.size()) != 0) {
    png.format = PNG_FORMAT_RGBA;
    png.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;  // treat 16 bits without a gamma as sRGB, as other programs do
    if (png_image_finish_read(&png, nullptr, image.texels.data(), 0, nullptr) != 0) return;
  }
  refuse(std::string("is a damaged PNG: ") + png.message);
}

ImageHeader readJpegHeader(std::span<const std::byte> file) {
  JpegDecoder decoder(file, false);
  if (!decoder.readHeader()) refuse(std::string("is a damaged JPEG: ") + decoder.failure());
  if (decoder.isCmyk()) refuse("is a CMYK JPEG; convert it to RGB");
  ImageHeader header = headerOf(decoder.size().x, decoder.size().y, 0);
  if (decoder.hasSeveralScans()) {
    const glm::u64vec2 blocks =
        (glm::u64vec2(decoder.size()) + (kJpegBlockPx - 1)) / kJpegBlockPx * kJpegBlockPx;
    header.working_bytes += blocks.x * blocks.y * kCoefficientBytes;
  }
  return header;
}

void decodeJpeg(std::span<const std::byte> file, Image& image, std::string& damage) {
  JpegDecoder decoder(file, false);
  if (!decoder.readHeader() || !decoder.readTexels(image.texels))
    refuse(std::string("is a damaged JPEG: ") + decoder.failure());
  damage = decoder.warning();
}

ImageHeader readWebpHeader(std::span<const std::byte> file) {
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(reinterpret_cast<const uint8_t*>(file.data()), file.size(), &features) != VP8_STATUS_OK)
    refuse("is a damaged WebP");
  if (features.has_animation != 0) refuse("is an animated WebP");
  ImageHeader header =
      headerOf(static_cast<uint64_t>(features.width), static_cast<uint64_t>(features.height), kTexelBytes);
  header.working_bytes += kWebpTableBytes;
  return header;
}

void decodeWebp(std::span<const std::byte> file, Image& image) {
  const size_t row_bytes = size_t{image.size.x} * kTexelBytes;
  if (WebPDecodeRGBAInto(reinterpret_cast<const uint8_t*>(file.data()), file.size(),
                         reinterpret_cast<uint8_t*>(image.texels.data()), image.texels.size() * kTexelBytes,
                         static_cast<int>(row_bytes)) == nullptr)
    refuse("is a damaged WebP");
}

bool isPng(std::span<const std::byte> file) {
  constexpr std::string_view kMagic = "\x89PNG\r\n\x1a\n";
  return file.size() >= kMagic.size() && std::memcmp(file.data(), kMagic.data(), kMagic.size()) == 0;
}

}  // namespace

ImageHeader readImageHeader(std::span<const std::byte> file) {
  if (isPng(file)) return readPngHeader(file);
  const auto kind = tileKind(file);
  if (!kind) refuse("is not a JPEG, PNG or WebP image; convert it to one");
  return *kind == TileKind::kJpeg ? readJpegHeader(file) : readWebpHeader(file);
}

Image decodeImage(std::span<const std::byte> file, uint64_t memory_bytes, std::string& damage) {
  damage.clear();
  const ImageHeader header = readImageHeader(file);
  if (header.working_bytes > memory_bytes)
    throw Error(ErrorCode::kLimit, "has " + std::to_string(header.width) + " x " +
                                       std::to_string(header.height) + " pixels, which need " +
                                       byteSizeAtLeast(header.working_bytes) +
                                       " of memory; raise --memory or scale the image down");
  Image image;
  image.size = {header.width, header.height};
  image.texels.resize(header.width * header.height);
  if (isPng(file)) {
    decodePng(file, image);
  } else if (tileKind(file) == TileKind::kJpeg) {
    decodeJpeg(file, image, damage);
  } else {
    decodeWebp(file, image);
  }
  return image;
}

uint64_t coarsePixels(std::span<const std::byte> file) {
  const ImageHeader header = readImageHeader(file);
  const uint64_t pixels = header.width * header.height;
  return tileKind(file) == TileKind::kJpeg ? pixels / (kJpegShrinking * kJpegShrinking) : pixels;
}

Image decodeCoarsely(std::span<const std::byte> file, uint64_t memory_bytes) {
  std::string damage;
  if (isPng(file) || tileKind(file) != TileKind::kJpeg) return decodeImage(file, memory_bytes, damage);
  JpegDecoder decoder(file, false);
  if (!decoder.readHeader()) refuse(std::string("is a damaged JPEG: ") + decoder.failure());
  if (readJpegHeader(file).working_bytes > memory_bytes) refuse("needs more memory");
  Image image;
  image.size = decoder.shrink();
  image.texels.resize(size_t{image.size.x} * image.size.y);
  if (image.texels.empty() || !decoder.readTexels(image.texels))
    refuse(std::string("is a damaged JPEG: ") + decoder.failure());
  return image;
}

}  // namespace lode::ingest
