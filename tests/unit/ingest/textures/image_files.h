#pragma once

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include <png.h>

#include "common/error.h"
#include "server/ingest/textures/image_decoder.h"

/// Synthetic images and their files.
namespace lode::test {

/// Makes an image of many smoothly changing colours; alpha is 255 or varies.
inline Image makePhoto(uint32_t width, uint32_t height, bool alpha = false) {
  Image image{{width, height}, {}};
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const auto wave = [&](double fx, double fy) {
        return static_cast<uint8_t>(127.5 + 127 * std::sin(fx * x + fy * y + 1));
      };
      image.texels.emplace_back(wave(0.021, 0.004), wave(0.003, 0.017), wave(0.011, 0.013),
                                alpha ? wave(0.005, 0.02) : 255);
    }
  return image;
}

inline std::vector<std::byte> pngOf(const Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = image.size.x;
  png.height = image.size.y;
  png.format = PNG_FORMAT_RGBA;
  png_alloc_size_t size = 0;
  png_image_write_to_memory(&png, nullptr, &size, 0, image.texels.data(), 0, nullptr);
  std::vector<std::byte> file(size);
  if (png_image_write_to_memory(&png, file.data(), &size, 0, image.texels.data(), 0, nullptr) == 0)
    throw Error(ErrorCode::kInternal, "a PNG could not be made");
  file.resize(size);
  return file;
}

/// Encodes a PNG with 16 bits per channel, each byte twice, without gamma or colour space.
inline std::vector<std::byte> png16Of(const Image& image) {
  std::vector<std::byte> file;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  const auto append = [](png_structp writer, png_bytep data, png_size_t size) {
    const auto bytes = std::as_bytes(std::span(data, size));
    auto& to = *static_cast<std::vector<std::byte>*>(png_get_io_ptr(writer));
    to.insert(to.end(), bytes.begin(), bytes.end());
  };
  png_set_write_fn(png, &file, append, nullptr);
  png_set_IHDR(png, info, image.size.x, image.size.y, 16, PNG_COLOR_TYPE_RGBA, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (size_t y = 0; y < image.size.y; ++y) {
    std::vector<uint8_t> row;
    for (size_t x = 0; x < image.size.x; ++x)
      for (int c = 0; c < 4; ++c) row.insert(row.end(), 2, image.texels[y * image.size.x + x][c]);
    png_write_row(png, row.data());
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return file;
}

inline void writeBytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// Makes a PNG file whose header declares the given size, with a valid checksum and data for one texel.
inline std::vector<std::byte> pngHeader(uint32_t width, uint32_t height) {
  std::vector<std::byte> file = pngOf(makePhoto(1, 1));
  for (int i = 0; i < 4; ++i) {
    file[16 + static_cast<size_t>(i)] = static_cast<std::byte>(width >> (24 - 8 * i) & 255);
    file[20 + static_cast<size_t>(i)] = static_cast<std::byte>(height >> (24 - 8 * i) & 255);
  }
  uint32_t crc = 0xffffffff;
  for (size_t i = 12; i < 29; ++i) {
    crc ^= std::to_integer<uint32_t>(file[i]);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
  }
  crc = ~crc;
  for (int i = 0; i < 4; ++i)
    file[29 + static_cast<size_t>(i)] = static_cast<std::byte>(crc >> (24 - 8 * i) & 255);
  return file;
}

}  // namespace lode::test
