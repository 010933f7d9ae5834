#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/io/output_target.h"

namespace lode::render {

/// An image of 8-bit sRGB pixels (red, green, blue, alpha), top row first.
struct Image {
  uint32_t width_px = 0, height_px = 0;
  std::vector<uint8_t> rgba;

  const uint8_t* pixel(uint32_t x, uint32_t y) const& noexcept {
    return rgba.data() + (static_cast<size_t>(y) * width_px + x) * 4;
  }
  /// Deleted, because the pointer would dangle.
  const uint8_t* pixel(uint32_t x, uint32_t y) const&& = delete;
};

/// Writes a PNG (colour only, no alpha). The file appears under its name only when it is complete.
/// @throws Error kIo.
void writePng(const std::filesystem::path& path, const Image& image, OutputName name = OutputName::kTyped);

}  // namespace lode::render
