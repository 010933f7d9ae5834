#include "server/store/tile_encoder.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <unordered_set>

#include <webp/encode.h>

#include "common/error.h"
#include "common/image/jpeg_decoder.h"

namespace lode::store {
namespace {

constexpr size_t kDrawingColours = 256;

/// Encodes a tile as JPEG. libjpeg reports errors by longjmp(), which skips destructors, so this function
/// must not create an object that has one.
/// @param bytes  receives memory that the caller must free().
bool compressJpeg(const Image& tile, int quality, unsigned char*& bytes, unsigned long& size) {
  jpeg_compress_struct info{};
  JpegErrors errors;
  info.err = errors.install(false);
  if (setjmp(errors.jump) != 0) {
    jpeg_destroy_compress(&info);
    return false;
  }
  jpeg_create_compress(&info);
  jpeg_mem_dest(&info, &bytes, &size);
  info.image_width = tile.size.x;
  info.image_height = tile.size.y;
  info.input_components = 4;
  info.in_color_space = JCS_EXT_RGBX;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, quality, TRUE);
  info.optimize_coding = TRUE;
  info.comp_info[0].h_samp_factor = info.comp_info[0].v_samp_factor = 1;
  jpeg_start_compress(&info, TRUE);
  while (info.next_scanline < info.image_height) {
    auto* row = reinterpret_cast<JSAMPLE*>(
        const_cast<glm::u8vec4*>(tile.texels.data() + size_t{info.next_scanline} * tile.size.x));
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  return true;
}

std::vector<std::byte> encodeJpeg(const Image& tile, int quality) {
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const bool done = compressJpeg(tile, quality, bytes, size);
  std::vector<std::byte> file;
  if (done) file.assign(reinterpret_cast<std::byte*>(bytes), reinterpret_cast<std::byte*>(bytes) + size);
  std::free(bytes);  // NOLINT(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory): libjpeg took it
  if (!done) throw Error(ErrorCode::kInternal, "libjpeg cannot encode a texture's tile");
  return file;
}

int appendTo(const uint8_t* data, size_t size, const WebPPicture* picture) {
  auto* const file = static_cast<std::vector<std::byte>*>(picture->custom_ptr);
  const auto* const bytes = reinterpret_cast<const std::byte*>(data);
  file->insert(file->end(), bytes, bytes + size);
  return 1;
}

std::vector<std::byte> encodeWebp(const Image& tile, bool lossless, int quality) {
  std::vector<std::byte> file;
  WebPConfig config;
  WebPPicture picture;
  if (WebPConfigPreset(&config, WEBP_PRESET_DEFAULT, static_cast<float>(quality)) == 0 ||
      WebPPictureInit(&picture) == 0)
    throw Error(ErrorCode::kInternal, "libwebp has another version than its headers");
  if (lossless) WebPConfigLosslessPreset(&config, 6);
  config.exact = 1;  // keep the colours of transparent texels, because filters mix them with their neighbours
  picture.use_argb = 1;
  picture.width = static_cast<int>(tile.size.x);
  picture.height = static_cast<int>(tile.size.y);
  picture.writer = appendTo;
  picture.custom_ptr = &file;
  const bool done = WebPPictureImportRGBA(&picture, reinterpret_cast<const uint8_t*>(tile.texels.data()),
                                          static_cast<int>(tile.size.x * sizeof(glm::u8vec4))) != 0 &&
                    WebPEncode(&config, &picture) != 0;
  WebPPictureFree(&picture);
  if (!done)
    throw Error(ErrorCode::kInternal, "libwebp cannot encode a texture's tile: error " +
                                          std::to_string(static_cast<int>(picture.error_code)));
  return file;
}

}  // namespace

TileCodec chooseCodec(const Image& image) {
  std::unordered_set<uint32_t> colours;
  uint32_t last = 0;
  for (const glm::u8vec4& texel : image.texels) {
    uint32_t colour = 0;
    std::memcpy(&colour, &texel, sizeof(colour));
    if (colour != last || colours.empty()) colours.insert(last = colour);
    if (colours.size() > kDrawingColours) break;
  }
  if (colours.size() <= kDrawingColours) return TileCodec::kLossless;
  const bool opaque = std::all_of(image.texels.begin(), image.texels.end(),
                                  [](const glm::u8vec4& texel) { return texel.a == 255; });
  return opaque ? TileCodec::kJpeg : TileCodec::kWebp;
}

std::vector<std::byte> encodeTile(const Image& tile, TileCodec codec, int quality) {
  if (codec == TileCodec::kJpeg) return encodeJpeg(tile, quality);
  return encodeWebp(tile, codec == TileCodec::kLossless, quality);
}

}  // namespace lode::store
