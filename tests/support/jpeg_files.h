#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <vector>

#include <glm/glm.hpp>
#include <jpeglib.h>

/// JPEG files for the tests of all modules that read them.
namespace lode::test {

/// Returns an image as a JPEG file of quality 95. @param components 1: grey, 3: colour, 4: the texels as
/// CMYK.
/// @param scans  scans of a progressive file; empty for a baseline file.
template <typename AnyImage>
std::vector<std::byte> jpegOf(const AnyImage& image, bool progressive = false, int components = 3,
                              std::span<const jpeg_scan_info> scans = {}) {
  jpeg_compress_struct encoder{};
  jpeg_error_mgr errors{};
  encoder.err = jpeg_std_error(&errors);
  jpeg_create_compress(&encoder);
  unsigned char* file = nullptr;
  unsigned long bytes = 0;
  jpeg_mem_dest(&encoder, &file, &bytes);
  encoder.image_width = image.size.x;
  encoder.image_height = image.size.y;
  encoder.input_components = components == 1 ? 1 : 4;
  encoder.in_color_space = components == 1 ? JCS_GRAYSCALE : components == 4 ? JCS_CMYK : JCS_EXT_RGBA;
  jpeg_set_defaults(&encoder);
  jpeg_set_quality(&encoder, 95, TRUE);
  if (progressive) jpeg_simple_progression(&encoder);
  if (!scans.empty()) {
    encoder.scan_info = scans.data();
    encoder.num_scans = static_cast<int>(scans.size());
  }
  jpeg_start_compress(&encoder, TRUE);
  std::vector<unsigned char> row;
  while (encoder.next_scanline < encoder.image_height) {
    row.clear();
    for (uint32_t x = 0; x < image.size.x; ++x) {
      const glm::u8vec4 texel = image.texels[encoder.next_scanline * image.size.x + x];
      for (int c = 0; c < encoder.input_components; ++c) row.push_back(texel[c]);
    }
    JSAMPROW rows = row.data();
    jpeg_write_scanlines(&encoder, &rows, 1);
  }
  jpeg_finish_compress(&encoder);
  const auto* const begin = reinterpret_cast<const std::byte*>(file);
  std::vector<std::byte> result(begin, begin + bytes);
  jpeg_destroy_compress(&encoder);
  std::free(file);
  return result;
}

/// Returns `count` scans of a progressive file. Each scan after the first has one coefficient of one
/// component.
inline std::vector<jpeg_scan_info> jpegScans(int count) {
  std::vector<jpeg_scan_info> scans{{3, {0, 1, 2}, 0, 0, 0, 0}};
  for (int i = 0; static_cast<int>(scans.size()) < count; ++i)
    scans.push_back({1, {i / 63}, i % 63 + 1, i % 63 + 1, 0, 0});
  return scans;
}

}  // namespace lode::test
