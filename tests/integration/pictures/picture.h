#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "tests/integration/programs/programs.h"

namespace lode::test {

/// A picture read from its file; its size is 0 if it cannot be read.
struct Picture {
  int width_px = 0, height_px = 0;
  std::vector<uint8_t> pixels;  ///< three bytes each

  explicit Picture(const std::filesystem::path& file);

  const uint8_t* pixel(int x, int y) const {
    return pixels.data() + (static_cast<size_t>(y) * width_px + x) * 3;
  }
  /// Returns the share of pixels that are not background, from a corner to the lower right one. The
  /// background is nearly one colour per row: it is dithered.
  double covered(int left, int top) const;
  /// Counts the levels of red in the middle row.
  size_t shades() const;
};

/// Writes a PNG. @param pixels  three bytes each.
void writePicture(const std::filesystem::path& file, int width_px, int height_px,
                  const std::vector<uint8_t>& pixels);

bool cannotDraw(const Outcome& outcome, const char* why);

}  // namespace lode::test
