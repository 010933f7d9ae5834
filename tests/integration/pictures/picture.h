#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "tests/integration/programs/programs.h"

namespace lode::test {

/// A picture that was read from a file. The size is 0 if the file cannot be read.
struct Picture {
  int width_px = 0, height_px = 0;
  std::vector<uint8_t> pixels;  ///< three bytes per pixel

  explicit Picture(const std::filesystem::path& file);

  const uint8_t* pixel(int x, int y) const {
    return pixels.data() + (static_cast<size_t>(y) * width_px + x) * 3;
  }
  /// Returns the share of pixels that are not background, in the area from (left, top) to the lower right
  /// corner. Each row of the background has nearly one colour; dithering changes it slightly.
  double covered(int left, int top) const;
  /// Counts the distinct values of red in the middle row.
  size_t shades() const;
};

/// Writes a PNG. @param pixels  three bytes per pixel.
void writePicture(const std::filesystem::path& file, int width_px, int height_px,
                  const std::vector<uint8_t>& pixels);

bool cannotDraw(const Outcome& outcome, const char* why);

}  // namespace lode::test
