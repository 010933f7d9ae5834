#include "common/tile_image.h"

#include <csetjmp>
#include <cstdio>
#include <string>

#include <jpeglib.h>
#include <webp/decode.h>

#include "common/error.h"
#include "common/texture_set.h"

namespace lode {
namespace {

constexpr int kMaxScans = 64;  // of a progressive JPEG; each costs a pass over the picture, however short

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorCode::kFormat, "damaged texture tile: " + why + "; fetch it again or rebuild the store");
}

/// libjpeg reports errors by a jump: nothing with a destructor may be made between setjmp() and it.
struct JpegErrors {
  jpeg_error_mgr manager{};  // first: libjpeg knows no more of it
  std::jmp_buf jump{};
  char message[JMSG_LENGTH_MAX]{};
};

[[noreturn]] void jumpOut(j_common_ptr info) {
  auto* const errors = reinterpret_cast<JpegErrors*>(info->err);
  errors->manager.format_message(info, errors->message);
  std::longjmp(errors->jump, 1);
}

/// Warnings are damage too: libjpeg would fill what is missing with grey.
void jumpOutOfWarnings(j_common_ptr info, int level) {
  if (level < 0) jumpOut(info);
}

void stopEndlessScans(j_common_ptr info) {
  const auto* const decoder = reinterpret_cast<j_decompress_ptr>(info);
  if (decoder->input_scan_number <= kMaxScans) return;
  auto* const errors = reinterpret_cast<JpegErrors*>(info->err);
  std::snprintf(errors->message, sizeof errors->message, "more than %d scans", kMaxScans);
  std::longjmp(errors->jump, 1);
}

/// @return false with errors.message set.
bool decodeJpegInto(std::span<const std::byte> file, TileImage& image, JpegErrors& errors) {
  jpeg_decompress_struct decoder{};
  jpeg_progress_mgr progress{};
  decoder.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = jumpOut;
  errors.manager.emit_message = jumpOutOfWarnings;
  if (setjmp(errors.jump) != 0) {
    jpeg_destroy_decompress(&decoder);
    return false;
  }
  jpeg_create_decompress(&decoder);
  progress.progress_monitor = stopEndlessScans;
  decoder.progress = &progress;
  jpeg_mem_src(&decoder, reinterpret_cast<const unsigned char*>(file.data()), file.size());
  jpeg_read_header(&decoder, TRUE);
  if (decoder.image_width != image.size.x || decoder.image_height != image.size.y) {
    std::snprintf(errors.message, sizeof errors.message, "it is %ux%u texels", decoder.image_width,
                  decoder.image_height);
    std::longjmp(errors.jump, 1);
  }
  decoder.out_color_space = JCS_EXT_RGBA;
  jpeg_start_decompress(&decoder);
  while (decoder.output_scanline < decoder.output_height) {
    auto* row = reinterpret_cast<JSAMPLE*>(image.texels.data() +
                                           static_cast<size_t>(decoder.output_scanline) * image.size.x);
    jpeg_read_scanlines(&decoder, &row, 1);
  }
  jpeg_finish_decompress(&decoder);
  jpeg_destroy_decompress(&decoder);
  return true;
}

void decodeJpeg(std::span<const std::byte> file, TileImage& image) {
  JpegErrors errors;
  if (!decodeJpegInto(file, image, errors)) refuse(std::string("libjpeg says: ") + errors.message);
}

void decodeWebp(std::span<const std::byte> file, TileImage& image) {
  const auto* const bytes = reinterpret_cast<const uint8_t*>(file.data());
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(bytes, file.size(), &features) != VP8_STATUS_OK) refuse("it is no WebP");
  if (features.has_animation != 0) refuse("it is animated");
  if (static_cast<uint32_t>(features.width) != image.size.x ||
      static_cast<uint32_t>(features.height) != image.size.y) {
    refuse("it is " + std::to_string(features.width) + "x" + std::to_string(features.height) + " texels");
  }
  const size_t room = image.texels.size() * sizeof(glm::u8vec4);
  if (WebPDecodeRGBAInto(bytes, file.size(), reinterpret_cast<uint8_t*>(image.texels.data()), room,
                         static_cast<int>(image.size.x * sizeof(glm::u8vec4))) == nullptr) {
    refuse("libwebp cannot decode it");
  }
}

}  // namespace

TileImage decodeTile(std::span<const std::byte> file, glm::uvec2 size) {
  if (size.x == 0 || size.y == 0 || size.x > kTilePx || size.y > kTilePx || file.size() > kMaxTileBytes) {
    throw Error(ErrorCode::kLimit, "a texture tile of " + std::to_string(size.x) + "x" +
                                       std::to_string(size.y) + " texels in " + std::to_string(file.size()) +
                                       " bytes is announced: outside the limits");
  }
  const std::optional<TileKind> kind = tileKind(file);
  if (!kind) refuse("it is neither JPEG nor WebP");
  TileImage image{size, std::vector<glm::u8vec4>(size_t{size.x} * size.y), {}};
  if (*kind == TileKind::kJpeg) {
    decodeJpeg(file, image);
  } else {
    decodeWebp(file, image);
  }
  return image;
}

}  // namespace lode
