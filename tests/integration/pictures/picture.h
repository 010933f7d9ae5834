#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "tests/integration/programs/programs.h"

namespace lode::test {

/// A picture read back from its file; of no size if it cannot be read.
struct Picture {
  int width_px = 0, height_px = 0;
  std::vector<uint8_t> pixels;  ///< three bytes each

  explicit Picture(const std::filesystem::path& file);

  const uint8_t* pixel(int x, int y) const {
    return pixels.data() + (static_cast<size_t>(y) * width_px + x) * 3;
  }
  /// Of a part of the picture, from a corner to the picture's lower right one: how much is not background.
  /// That is nearly one colour a row: it is dithered.
  double covered(int left, int top) const;
  /// Levels of red in its middle row.
  size_t shades() const;
};

/// Writes a PNG. @param pixels  three bytes each.
void writePicture(const std::filesystem::path& file, int width_px, int height_px,
                  const std::vector<uint8_t>& pixels);

bool cannotDraw(const Outcome& outcome, const char* why);

}  // namespace lode::test
